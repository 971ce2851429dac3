// SPDX-License-Identifier: Apache-2.0
#include "host/listen/listen.hpp"

#include <chrono>
#include <random>

#include "host/listen/key_folder.hpp"
#include "host/listen/once.hpp"
#include "host/listen/record_folder.hpp"
#include "host/listen/status_line.hpp"
#include "host/listen/surface_count.hpp"

namespace srd::host {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTurn{5};
constexpr int kMaxPerTurn = 256;  // datagrams between two looks at what is due
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kShowEvery = kSecond / 5;

std::int64_t steady_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::int64_t wall_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

// Rows a second over the last few shows.
class Rate {
 public:
  double update(std::uint64_t rows, std::int64_t now) {
    if (now - since_ns_ >= kSecond) {
      hz_ = since_ns_ == 0 ? 0 : static_cast<double>(rows - since_rows_) * 1e9 / static_cast<double>(now - since_ns_);
      since_ns_ = now;
      since_rows_ = rows;
    }
    return hz_;
  }

 private:
  std::int64_t since_ns_ = 0;
  std::uint64_t since_rows_ = 0;
  double hz_ = 0;
};

struct Listener {
  const ListenOptions& options;
  UdpSocket socket;
  Session session;
  Rate rate{};
  std::int64_t shown_ns = 0;
  std::size_t shared_told = 0;    // of the receiver's shared_ids()
  std::size_t concerns_told = 0;  // of its concerns()

  void send(const std::vector<Answer>& answers) {
    // One that the system does not take is made up for by the next.
    for (const Answer& answer : answers) (void)socket.send_to(answer.to, answer.datagram);
  }

  Outcome<void> turn() {
    std::array<std::uint8_t, proto::kMaxDatagram> buffer;
    Address from;
    std::chrono::nanoseconds wait = kTurn;
    for (int i = 0; i < kMaxPerTurn && !session.has_all_rows(); ++i) {
      const std::ptrdiff_t size = socket.receive(buffer, wait, &from);
      if (size < 0) break;
      wait = std::chrono::nanoseconds(0);
      // Longer ones are cut to the buffer, and their check does not hold.
      session.receive(std::span(buffer).first(std::min(static_cast<std::size_t>(size), buffer.size())), from);
    }
    const auto answers = session.advance();
    if (!answers) return answers.error();
    send(*answers);
    const auto& shared = session.receiver().shared_ids();
    for (; shared_told < shared.size(); ++shared_told)
      options.notify("warning: " + shared_id_text(session.receiver(), shared[shared_told]));
    const auto& concerns = session.receiver().concerns();
    for (; concerns_told < concerns.size(); ++concerns_told)
      options.notify("warning: " + concern_text(concerns[concerns_told], options.keys.string()));
    const std::int64_t now = steady_ns();
    if (options.show && now - shown_ns >= kShowEvery) {
      options.show(status_line(session, rate.update(session.rows(), now)));
      shown_ns = now;
    }
    return {};
  }
};

std::uint64_t random_number() {
  std::random_device device;
  return (std::uint64_t{device()} << 32) | device();
}

}  // namespace

Outcome<void> listen(const ListenOptions& options, const std::atomic<bool>& stop) {
  const auto address = Address::parse(options.bind, "--bind");
  if (!address) return address.error();
  auto socket = UdpSocket::bind(*address);
  if (!socket) return socket.error();
  std::optional<KeyFolder> keys;
  if (!options.keys.empty()) {
    auto opened = KeyFolder::open(options.keys);
    if (!opened) return opened.error();
    keys = std::move(*opened);
  }
  if (!keys && !address->is_loopback())
    options.notify("warning: " + socket->local().text() +
                   ": without a key anyone on this network can send frames; nothing proves which node they are from "
                   "(srd keygen, --keys)");
  std::unique_ptr<CoefficientFile> csv;
  std::vector<FrameSink*> sinks = options.further_sinks;
  SurfaceCount surfaces;
  sinks.push_back(&surfaces);
  SessionOptions session_options;
  session_options.clock = steady_ns;
  session_options.session = random_number();
  if (keys) session_options.keys = [&](const proto::NodeId& node) { return keys->keys_of(node, steady_ns(), options.notify); };
  if (options.count > 0) session_options.most_rows = options.count;
  std::unique_ptr<RecordFolder> record;
  std::vector<std::unique_ptr<Once>> once;
  std::optional<FramesByBoot> in_all;
  const auto keep_in = [&](FrameSink& sink, const FramesByBoot& has) {
    sinks.push_back(once.emplace_back(std::make_unique<Once>(sink, has)).get());
    in_all = in_all ? in_both(*in_all, has) : has;
  };
  if (!options.csv.empty()) {
    auto opened = CoefficientFile::open(options.csv, options.open);
    if (!opened) return opened.error();
    csv = std::move(*opened);
    keep_in(*csv, csv->frames_in_file());
  }
  if (!options.record.empty()) {
    auto opened = RecordFolder::open(options.record, wall_ns);
    if (!opened) return opened.error();
    record = std::move(*opened);
    keep_in(*record, record->frames_in_file());
  }
  if (in_all) session_options.in_file = std::move(*in_all);
  std::unique_ptr<Fusion> fusion;
  if (options.fuse) {
    FusionOptions fuse = *options.fuse;
    fuse.boot = random_number();
    fuse.notify = options.notify;
    fuse.sinks = options.further_sinks;
    if (csv) fuse.sinks.push_back(csv.get());
    if (record) fuse.sinks.push_back(record.get());
    fusion = std::make_unique<Fusion>(std::move(fuse));
    // Before the others: they are flushed with what it gave them.
    sinks.insert(sinks.begin(), fusion.get());
  }
  if (options.listening) options.listening(socket->local());

  Listener listener{options, std::move(*socket), Session(std::move(session_options), std::move(sinks))};
  Session& session = listener.session;
  const std::int64_t start = steady_ns();
  const auto over = [&] {
    return session.has_all_rows() || (options.seconds > 0 && static_cast<double>(steady_ns() - start) >= options.seconds * 1e9);
  };
  while (!stop.load() && !over())
    if (auto done = listener.turn(); !done) return done;
  // The last frames of live nodes may wait for one that is being sent again.
  const std::int64_t ending = steady_ns();
  while (!session.has_all_rows() && session.waits_for_a_gap(kSecond) && steady_ns() - ending < kSecond)
    if (auto done = listener.turn(); !done) return done;
  const auto answers = session.finish(!session.has_all_rows());
  if (!answers) return answers.error();
  for (int i = 0; i < 3; ++i) listener.send(*answers);  // nobody asks again

  options.notify(summary_table(session));
  for (const std::string& note : surfaces.notes()) options.notify("note: " + note);
  if (fusion)
    for (const std::string& line : fusion->summary()) options.notify(line);
  if (csv)
    for (const std::string& note : csv->notes()) options.notify("note: " + note);
  if (csv && csv->files().size() > 1) {
    std::string files = "nodes with different modes have files of their own:";
    for (const auto& file : csv->files()) files += " " + file.string();
    options.notify(files);
  }
  return {};
}

}  // namespace srd::host
