// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/transmitter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include "proto/host_codec.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

TransmitterOptions to_a_name(const HostLookup::Resolve& resolve) {
  TransmitterOptions options;
  options.sender.from = {*proto::NodeId::make("node"), 42};
  options.sender.timing.linger = 100'000'000;
  options.host = "flume-pc:47810";
  options.resolve = resolve;
  return options;
}

proto::CoefficientFrame a_frame_without_a_surface() {
  proto::CoefficientFrame frame;
  frame.status = proto::FrameStatus::kFailed;
  frame.model.modes = dsp::ModeList::standard(1).value();
  frame.model.lx = frame.model.ly = 200;
  frame.refractive_index = 1.333f;
  return frame;
}

bool within_seconds(int most, const std::function<bool()>& met) {
  const auto end = Clock::now() + seconds(most);
  while (!met() && Clock::now() < end) std::this_thread::sleep_for(milliseconds(1));
  return met();
}

TEST(Transmitter, SendsToANameOnceItHasAnAddress) {
  auto host = UdpSocket::bind(*Address::parse("127.0.0.1:0", "test"));
  ASSERT_TRUE(host.ok());
  const auto network_up = std::make_shared<std::atomic<bool>>(false);
  auto started = Transmitter::start(to_a_name(
      [network_up, address = host->local()](std::string_view text, std::string_view) -> Outcome<std::vector<Address>> {
        EXPECT_EQ(text, "flume-pc:47810");
        if (!*network_up) return Problem{Exit::kNetwork, "no name server yet"};
        return std::vector{address};
      }));
  ASSERT_TRUE(started.ok()) << started.error().text();
  EXPECT_TRUE(within_seconds(10, [&] { return (*started)->host_problem() == "no name server yet"; }));
  std::array<std::uint8_t, proto::kMaxDatagram> datagram{};
  EXPECT_LT(host->receive(datagram, milliseconds(0)), 0);
  *network_up = true;
  EXPECT_GT(host->receive(datagram, seconds(10)), 0);
  EXPECT_EQ((*started)->host_problem(), "");
  EXPECT_EQ((*started)->finish().host_problem, "");
}

// As after a kill: the file of an earlier boot is there, and its frames go to the host beside this boot's.
TEST(Transmitter, DeliversWhatAnEarlierRunHadSpilled) {
  const fakes::ScratchFolder folder;
  const proto::BootId earlier{*proto::NodeId::make("node"), 41};
  TransmitterOptions options = to_a_name([](auto, auto) -> Outcome<std::vector<Address>> { return std::vector<Address>(); });
  options.spill = {.folder = folder.path(), .frames = 100, .frame_bytes = 400};
  {
    auto spill = SpillFile::create(options.spill, earlier, 1);
    ASSERT_TRUE(spill.ok());
    SenderOptions before;
    before.from = earlier;
    before.ring_frames = 100;
    Sender sender(before);
    sender.keep_in(spill->get());
    for (int i = 0; i < 40; ++i) ASSERT_TRUE(sender.push(a_frame_without_a_surface()));
  }
  auto host = UdpSocket::bind(*Address::parse("127.0.0.1:0", "test"));
  ASSERT_TRUE(host.ok());
  options.host = host->local().text();
  auto started = Transmitter::start(options);
  ASSERT_TRUE(started.ok()) << started.error().text();
  EXPECT_EQ((*started)->spill_note(), "40 frames of 1 earlier run are delivered first to last");
  ASSERT_TRUE((*started)->push(a_frame_without_a_surface()));
  std::map<std::uint64_t, std::set<std::uint64_t>> heard;  // by boot
  std::uint64_t serial = 0;
  std::array<std::uint8_t, proto::kMaxDatagram> buffer{};
  const bool all = within_seconds(10, [&] {
    Address from;
    const auto size = host->receive(buffer, milliseconds(20), &from);
    if (size <= 0) return false;
    const auto message = proto::decode_node_datagram(std::span(buffer).first(static_cast<std::size_t>(size)));
    if (message) {
      auto& numbers = heard[message->header.from.boot];
      if (std::holds_alternative<proto::CoefficientFrame>(message->content)) numbers.insert(message->header.sequence);
      proto::Acknowledgement answer;
      answer.of = message->header.from;
      answer.session = 1;
      answer.serial = ++serial;
      while (numbers.contains(answer.first_missing)) ++answer.first_missing;
      answer.known_end = answer.first_missing;
      (void)host->send_to(from, proto::encode_datagram(answer));
    }
    return heard[41].size() == 40 && heard[42].size() == 1;
  });
  EXPECT_TRUE(all);
  EXPECT_TRUE(within_seconds(5, [&] { return std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1; }));
  EXPECT_EQ((*started)->finish().spilled, 0u);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SlowTransmitter, FollowsAHostThatGotAnotherAddress) {
  auto before = UdpSocket::bind(*Address::parse("127.0.0.1:0", "test")),
       after = UdpSocket::bind(*Address::parse("127.0.0.2:0", "test"));
  ASSERT_TRUE(before.ok() && after.ok());
  const auto moved = std::make_shared<std::atomic<bool>>(false);
  auto started = Transmitter::start(to_a_name(
      [moved, from = before->local(), to = after->local()](
          std::string_view, std::string_view) -> Outcome<std::vector<Address>> { return std::vector{*moved ? to : from}; }));
  ASSERT_TRUE(started.ok()) << started.error().text();
  std::array<std::uint8_t, proto::kMaxDatagram> datagram{};
  EXPECT_GT(before->receive(datagram, seconds(10)), 0);
  EXPECT_LT(after->receive(datagram, milliseconds(0)), 0);
  *moved = true;
  EXPECT_GT(after->receive(datagram, seconds(10)), 0);
}

TEST(Transmitter, ALookupThatBlocksHoldsUpNeitherRecordsNorTheEnd) {
  std::promise<void> answer;
  auto started =
      Transmitter::start(to_a_name([blocked = answer.get_future().share()](auto, auto) -> Outcome<std::vector<Address>> {
        blocked.wait();
        return Problem{Exit::kNetwork, "nobody answered"};
      }));
  ASSERT_TRUE(started.ok()) << started.error().text();
  const proto::CoefficientFrame frame = a_frame_without_a_surface();
  constexpr std::uint64_t kRecords = 300;  // several times what the queue holds
  for (std::uint64_t n = 1; n <= kRecords; ++n) {
    EXPECT_TRUE((*started)->push(frame)) << n;
    if (n % 50 == 0) {
      ASSERT_TRUE(within_seconds(10, [&] { return (*started)->unacknowledged() == n; })) << n;
    }
  }
  const auto begin = Clock::now();
  const TransmitterReport report = (*started)->finish();
  started->reset();
  EXPECT_LT(Clock::now() - begin, seconds(5));
  EXPECT_EQ(report.unacknowledged, kRecords);
  EXPECT_NE(report.host_problem.find("flume-pc"), std::string::npos) << report.host_problem;
  answer.set_value();
}

TEST(Transmitter, RefusesWhatIsNoAddress) {
  TransmitterOptions options = to_a_name(Address::parse_all);
  options.host = "flume-pc";
  const auto refused = Transmitter::start(options);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().exit, Exit::kUsage);
}

}  // namespace
}  // namespace srd::firmware
