// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/transmitter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <thread>

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
