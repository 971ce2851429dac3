// SPDX-License-Identifier: Apache-2.0
// srd listen and the node's transmitter over real sockets on loopback.
#include "host/listen/listen.hpp"

#include <future>
#include <memory>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/support/csv_table.hpp"
#include "drivers/support/key_file.hpp"
#include "firmware/transmit/transmitter.hpp"
#include "host/keygen/keygen.hpp"
#include "host/listen/command.hpp"
#include "host/listen/status_line.hpp"
#include "tests/fakes/command_run.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/host/delivery_simulation.hpp"
#include "tests/host/lossy_relay.hpp"

namespace srd::host {
namespace {

// srd listen in a thread of its own.
class Listening {
 public:
  explicit Listening(ListenOptions options) {
    options.bind = bind_.empty() ? "127.0.0.1:0" : bind_;
    options.notify = [this](const std::string& text) { said += text; };
    auto bound = std::make_shared<std::promise<Address>>();
    options.listening = [bound](const Address& address) { bound->set_value(address); };
    thread_ = std::thread([this, options] { outcome = std::make_unique<Outcome<void>>(listen(options, stop_)); });
    address_ = bound->get_future().get();
  }
  ~Listening() { end(); }
  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  void wait() { thread_.join(); }
  [[nodiscard]] const Address& address() const { return address_; }
  std::unique_ptr<Outcome<void>> outcome;
  std::string said;

 private:
  std::string bind_;
  Address address_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

std::unique_ptr<firmware::Transmitter> start_node(const char* name, std::uint64_t boot, const Address& host,
                                                  bool overwrite = true) {
  firmware::TransmitterOptions options;
  options.sender.from = {*proto::NodeId::make(name), boot};
  options.sender.overwrite = overwrite;
  options.host = host.text();
  auto transmitter = firmware::Transmitter::start(options);
  EXPECT_TRUE(transmitter.ok());
  return std::move(*transmitter);
}

void expect_rows(const std::filesystem::path& file, std::map<std::string, std::uint64_t> rows_of_node) {
  const auto table = CsvTable::read(file);
  ASSERT_TRUE(table.ok()) << table.error().text();
  const auto nodes = table->words("node").value();
  const auto sequences = table->unsigned_integers("sequence").value();
  std::map<std::string, std::uint64_t> next;
  for (std::size_t row = 0; row < nodes.size(); ++row) ASSERT_EQ(sequences[row], next[nodes[row]]++);
  EXPECT_EQ(next, rows_of_node);
}

TEST(Listen, RecordsThreeNodesOverABadNetwork) {
  const fakes::ScratchFolder folder;
  const auto file = folder.path() / "run.csv";
  constexpr std::uint64_t kFrames = 600;
  {
    Listening host({.csv = file});
    std::vector<std::thread> nodes;
    std::vector<std::unique_ptr<simulated::LossyRelay>> relays;
    std::array<firmware::TransmitterReport, 3> reports;
    for (std::size_t i = 0; i < 3; ++i) {
      relays.push_back(std::make_unique<simulated::LossyRelay>(host.address(), 0.3, 0.1, std::chrono::milliseconds(20), i));
      nodes.emplace_back([&, i] {
        const auto node = start_node(("cam-" + std::to_string(i)).c_str(), 100 + i, relays[i]->address());
        for (std::uint64_t s = 0; s < kFrames; ++s) {
          EXPECT_TRUE(node->push(simulated::Simulation::frame_at(static_cast<std::int64_t>(s))));
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        reports[i] = node->finish();
      });
    }
    for (auto& node : nodes) node.join();
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(reports[i].unacknowledged, 0u);
      EXPECT_EQ(reports[i].counts.lost, 0u);
      EXPECT_TRUE(reports[i].host_heard);
      EXPECT_GT(relays[i]->lost(), 100u);
    }
    host.end();
    EXPECT_TRUE(host.outcome->ok());
    EXPECT_NE(host.said.find("cam-2"), std::string::npos);
  }
  expect_rows(file, {{"cam-0", kFrames}, {"cam-1", kFrames}, {"cam-2", kFrames}});
}

TEST(Listen, EndsAfterTheRowsAskedForAndGoesOnWithAppend) {
  const fakes::ScratchFolder folder;
  const auto file = folder.path() / "run.csv";
  Address address;
  std::atomic<bool> cancelled{false};
  std::unique_ptr<firmware::Transmitter> node;
  {
    Listening host({.csv = file, .count = 150});
    address = host.address();
    node = start_node("cam", 1, address, false);
    for (int i = 0; i < 400; ++i)
      while (!node->push(simulated::Simulation::frame_at(i))) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    host.wait();
    EXPECT_TRUE(host.outcome->ok());
  }
  expect_rows(file, {{"cam", 150}});
  {
    ListenOptions again{.csv = file, .open = OpenMode::kNew};
    again.bind = address.text();
    again.notify = [](const std::string&) {};
    const auto refused = listen(again, cancelled);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().exit, Exit::kUsage);
    again.open = OpenMode::kAppend;
    again.count = 250;
    EXPECT_TRUE(listen(again, cancelled).ok());
  }
  EXPECT_EQ(node->finish().unacknowledged, 0u);
  expect_rows(file, {{"cam", 400}});
}

TEST(Listen, ForgedDatagramsChangeNothing) {
  const fakes::ScratchFolder folder;
  const auto file = folder.path() / "run.csv";
  Listening host({.csv = file});
  auto forger = UdpSocket::connect(host.address()).value();
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> bytes(random() % 1400);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    (void)forger.send(bytes);
  }
  const auto node = start_node("cam", 1, host.address());
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(node->push(simulated::Simulation::frame_at(i)));
  EXPECT_EQ(node->finish().unacknowledged, 0u);
  host.end();
  expect_rows(file, {{"cam", 20}});
  EXPECT_NE(host.said.find("rejected"), std::string::npos);
}

TEST(Listen, NodeOutlivesAHostThatComesLate) {
  // A port where nobody listens yet.
  const Address address = UdpSocket::bind(Address::parse("127.0.0.1:0", "test").value())->local();
  const auto node = start_node("cam", 1, address);
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(node->push(simulated::Simulation::frame_at(i)));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const fakes::ScratchFolder folder;
  ListenOptions options{.bind = address.text(), .csv = folder.path() / "run.csv", .count = 50};
  options.notify = [](const std::string&) {};
  const std::atomic<bool> never{false};
  EXPECT_TRUE(listen(options, never).ok());
  EXPECT_EQ(node->finish().unacknowledged, 0u);
  expect_rows(options.csv, {{"cam", 50}});
}

// As Debian's own /etc/hosts has it for localhost: nobody listens at the first address.
TEST(Listen, ANodeTriesEveryAddressOfItsHostUntilOneAnswers) {
  if (!UdpSocket::bind(Address::parse("[::1]:0", "test").value()).ok()) GTEST_SKIP() << "no IPv6 on this machine";
  for (const bool someone_else : {false, true}) {
    const fakes::ScratchFolder folder;
    const auto file = folder.path() / "run.csv";
    Listening host({.csv = file});
    const Address right = Address::parse(host.address().text(), "test").value();
    const Address wrong = Address::parse("[::1]:" + std::to_string(right.port()), "test").value();
    // One who takes everything and never answers: no error tells of it.
    std::optional<UdpSocket> silent;
    if (someone_else) silent.emplace(UdpSocket::bind(wrong).value());
    firmware::TransmitterOptions options;
    options.sender.from = {*proto::NodeId::make("cam"), 7};
    options.host = "localhost:" + std::to_string(right.port());
    options.resolve = [&](std::string_view, std::string_view) -> Outcome<std::vector<Address>> {
      return std::vector{wrong, right};
    };
    auto node = firmware::Transmitter::start(options);
    ASSERT_TRUE(node.ok()) << node.error().text();
    for (int i = 0; i < 20; ++i) EXPECT_TRUE((*node)->push(simulated::Simulation::frame_at(i)));
    const firmware::TransmitterReport report = (*node)->finish();
    EXPECT_EQ(report.unacknowledged, 0u);
    EXPECT_EQ(report.host_address, right.text() + " answers; it is also " + wrong.text());
    host.end();
    expect_rows(file, {{"cam", 20}});
  }
}

TEST(Listen, TellsOfANodeThatMeasuredNothing) {
  const fakes::ScratchFolder folder;
  Listening host({.csv = folder.path() / "run.csv"});
  for (const bool measures : {true, false}) {
    const auto node = start_node(measures ? "good" : "blind", 1, host.address());
    for (int i = 0; i < 5; ++i) {
      proto::CoefficientFrame frame = simulated::Simulation::frame_at(i);
      if (!measures) {
        frame.coefficients.resize(0);
        frame.information = {};
        frame.status = i == 0 ? proto::FrameStatus::kBadFrame : proto::FrameStatus::kSearching;
      }
      EXPECT_TRUE(node->push(frame));
    }
    EXPECT_EQ(node->finish().unacknowledged, 0u);
  }
  host.end();
  EXPECT_NE(host.said.find("blind: no frame has a surface: 4 searching, 1 bad_frame"), std::string::npos) << host.said;
  EXPECT_EQ(host.said.find("good: no frame"), std::string::npos) << host.said;
}

TEST(Listen, AHostWithoutAnAnswerFromAnyAddressSaysAllOfThem) {
  const Address a = UdpSocket::bind(Address::parse("127.0.0.1:0", "test").value())->local();
  const Address b = UdpSocket::bind(Address::parse("127.0.0.2:0", "test").value())->local();
  firmware::TransmitterOptions options;
  options.sender.from = {*proto::NodeId::make("cam"), 7};
  options.sender.timing.linger = 300'000'000;
  options.host = "flume-pc:47810";
  options.resolve = [&](std::string_view, std::string_view) -> Outcome<std::vector<Address>> { return std::vector{a, b}; };
  auto node = firmware::Transmitter::start(options);
  ASSERT_TRUE(node.ok());
  EXPECT_TRUE((*node)->push(simulated::Simulation::frame_at(0)));
  const firmware::TransmitterReport report = (*node)->finish();
  EXPECT_EQ(report.unacknowledged, 1u);
  EXPECT_EQ(report.host_address, "none of its addresses answers: " + a.text() + ", " + b.text());
}

// Over real sockets, with the folder that srd keygen makes; a node that is added while it runs; a host for everyone.
TEST(ListenWithKeys, RecordsTheNodesWhoseKeysItHasAndThoseAddedLater) {
  const fakes::ScratchFolder folder;
  const auto file = folder.path() / "run.csv", keys = folder.path() / "keys";
  const auto key_of = [&](const char* node) {
    return proto::Key(KeyFile::read(keys / (std::string(node) + ".key")).value().keys.front().bytes());
  };
  ASSERT_TRUE(keygen({.nodes = {"cam-1"}, .folder = keys}).ok());
  std::atomic<bool> never{true};
  std::string said;
  ListenOptions open{.bind = "0.0.0.0:0", .keys = keys};
  open.notify = [&](const std::string& text) { said += text; };
  EXPECT_TRUE(listen(open, never).ok());
  EXPECT_EQ(said.find("without a key"), std::string::npos) << said;

  Listening host({.csv = file, .keys = keys});
  const auto send = [&](const char* name, std::optional<proto::Key> key, std::int64_t linger) {
    firmware::TransmitterOptions options;
    options.sender.from = {*proto::NodeId::make(name), 1};
    options.sender.key = key;
    options.sender.timing.linger = linger;
    options.host = host.address().text();
    auto node = firmware::Transmitter::start(options);
    EXPECT_TRUE(node.ok());
    for (int i = 0; i < 30; ++i) EXPECT_TRUE((*node)->push(simulated::Simulation::frame_at(i)));
    return (*node)->finish().unacknowledged;
  };
  EXPECT_EQ(send("cam-1", key_of("cam-1"), 5'000'000'000), 0u);
  EXPECT_EQ(send("cam-2", std::nullopt, 300'000'000), 30u);
  EXPECT_EQ(send("cam-3", key_of("cam-1"), 300'000'000), 30u);
  ASSERT_TRUE(keygen({.nodes = {"cam-3"}, .folder = keys}).ok());
  EXPECT_EQ(send("cam-3", key_of("cam-3"), 5'000'000'000), 0u);
  host.end();
  expect_rows(file, {{"cam-1", 30}, {"cam-3", 30}});
  EXPECT_NE(host.said.find("node 'cam-2' sends without a key"), std::string::npos) << host.said;
  EXPECT_NE(host.said.find("node 'cam-3' has a key, and there is none for it"), std::string::npos) << host.said;
}

TEST(ListenWithKeys, RefusesAFolderOfKeysThatOthersCanRead) {
  const fakes::ScratchFolder folder;
  const auto keys = folder.path() / "keys";
  const std::atomic<bool> stop{true};
  ListenOptions options{.bind = "127.0.0.1:0", .keys = keys};
  options.notify = [](const std::string&) {};
  const auto refused = [&](const std::string& part) {
    const auto done = listen(options, stop);
    EXPECT_FALSE(done.ok());
    if (done.ok()) return;
    EXPECT_EQ(done.error().exit, Exit::kUsage);
    EXPECT_NE(done.error().text().find(part), std::string::npos) << done.error().text();
  };
  refused("srd keygen");
  std::filesystem::create_directory(keys);
  refused("no key in the folder");
  ASSERT_TRUE(keygen({.nodes = {"cam-1"}, .folder = keys}).ok());
  EXPECT_TRUE(listen(options, stop).ok());
  std::filesystem::permissions(keys / "cam-1.key", std::filesystem::perms::others_read, std::filesystem::perm_options::add);
  refused("chmod 600");
  std::filesystem::permissions(keys / "cam-1.key", std::filesystem::perms::others_read, std::filesystem::perm_options::remove);
  std::filesystem::rename(keys / "cam-1.key", keys / "cam-2.key");
  refused("cam-1.key");
}

TEST(Listen, WarnsWhenAnyoneCouldSend) {
  std::atomic<bool> stop{true};
  std::string said;
  ListenOptions options{.bind = "0.0.0.0:0"};
  options.notify = [&](const std::string& text) { said += text; };
  EXPECT_TRUE(listen(options, stop).ok());
  EXPECT_NE(said.find("without a key"), std::string::npos);
  said.clear();
  options.bind = "127.0.0.1:0";
  EXPECT_TRUE(listen(options, stop).ok());
  EXPECT_EQ(said.find("without a key"), std::string::npos);
}

TEST(Listen, CommandGivesExitCodes) {
  const fakes::ScratchFolder folder;
  const auto run = [](std::vector<std::string> words) { return fakes::run_command(add_listen_command, std::move(words)).exit; };
  const std::string csv = (folder.path() / "run.csv").string();
  EXPECT_EQ(run({"listen", "--bind", "127.0.0.1:0", "--csv", csv, "--for", "0.01"}), 0);
  EXPECT_EQ(run({"listen", "--bind", "127.0.0.1:0", "--csv", csv, "--for", "0.01"}), 2);
  EXPECT_EQ(run({"listen", "--bind", "127.0.0.1:0", "--csv", csv, "--for", "0.01", "--force"}), 0);
  EXPECT_EQ(run({"listen", "--bind", "127.0.0.1:0", "--csv", csv, "--for", "0.01", "--append"}), 0);
  EXPECT_EQ(run({"listen", "--append"}), 2);
  EXPECT_EQ(run({"listen", "--bind", "nonsense", "--for", "0.01"}), 2);
  EXPECT_EQ(run({"listen", "--bind", "192.0.2.1:1", "--for", "0.01"}), 5);
  EXPECT_EQ(run({"listen", "--count", "0"}), 2);
}

TEST(StatusLine, ListsLostFramesAsPeopleCount) {
  EXPECT_EQ(range_text({{5, 6}, {10, 20}}, 5), "5, 10-19");
  EXPECT_EQ(range_text({{1, 2}, {3, 4}, {5, 6}}, 2), "1, 3, ..");
}

}  // namespace
}  // namespace srd::host
