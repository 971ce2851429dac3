// SPDX-License-Identifier: Apache-2.0
#include "host/listen/status_line.hpp"

#include <gtest/gtest.h>

#include "proto/node_codec.hpp"

namespace srd::host {
namespace {

using proto::Throttled;

class NodeConcerns : public testing::Test {
 protected:
  NodeConcerns() : session_(options(), {}) {}
  static SessionOptions options() {
    SessionOptions out;
    out.clock = [] { return std::int64_t{0}; };
    return out;
  }
  void hear(const char* node, std::uint64_t boot, const proto::NodeStatus& status) {
    std::array<std::uint8_t, proto::kMaxDatagram> buffer{};
    const auto size = proto::encode(proto::BootId{*proto::NodeId::make(node), boot}, 0, status, buffer);
    ASSERT_TRUE(size.ok());
    session_.receive(std::span(buffer).first(proto::seal(buffer, *size, 0)), Address());
  }
  std::string line() { return status_line(session_, 50); }
  Session session_;
};

proto::NodeStatus warm(float temperature_c) {
  proto::NodeStatus status;
  status.temperature_c = temperature_c;
  status.clock_state = proto::ClockState::kSynchronised;
  return status;
}

TEST_F(NodeConcerns, AHealthyNodeShowsItsTemperatureOnly) {
  hear("a", 1, warm(61.4f));
  EXPECT_TRUE(line().ends_with("duplicates 0  61 C")) << line();
  EXPECT_EQ(summary_table(session_).find("clock"), std::string::npos);
}

TEST_F(NodeConcerns, NamesTheNodeAndWhatIsWrongWithIt) {
  hear("a", 1, warm(50));
  proto::NodeStatus status = warm(84);
  status.throttled = Throttled::kThrottled | Throttled::kThrottled << Throttled::kEverShift;
  status.clock_state = proto::ClockState::kUnsynchronised;
  status.recording = proto::RecordState::kStopped;
  status.disconnects = 2;
  status.restarts = 3;
  status.last_end = *proto::FixedText<95>::make("SIGBUS");
  hear("b", 1, status);
  EXPECT_TRUE(
      line().ends_with("  84 C  b: throttled, clock not synchronised, recording stopped, camera was away 2 times, "
                       "restart 3 after: SIGBUS"))
      << line();
  EXPECT_NE(summary_table(session_).find("restart 3 after: SIGBUS"), std::string::npos);
}

TEST_F(NodeConcerns, ImpossibleTimesOfTheCamerasDriverAreTold) {
  proto::NodeStatus status = warm(60);
  status.bad_stamps = 12;
  hear("a", 1, status);
  EXPECT_NE(line().find("a: 12 frames timed by their arrival"), std::string::npos) << line();
}

TEST_F(NodeConcerns, WhatIsOverIsToldAsPast) {
  proto::NodeStatus status = warm(50);
  status.throttled = Throttled::kUnderVoltage << Throttled::kEverShift;
  hear("a", 1, status);
  EXPECT_NE(line().find("a: was once under-voltage"), std::string::npos) << line();
}

TEST_F(NodeConcerns, OnlyTheBootThatANodeIsInCounts) {
  proto::NodeStatus old = warm(90);
  old.clock_state = proto::ClockState::kUnsynchronised;
  hear("a", 9, old);
  hear("a", 2, warm(40));
  EXPECT_TRUE(line().ends_with("  40 C")) << line();
}

TEST_F(NodeConcerns, ManyNodesWithTheSameTroubleStayALine) {
  proto::NodeStatus status = warm(60);
  status.clock_state = proto::ClockState::kUnsynchronised;
  for (const char* node : {"a", "b", "c", "d"}) hear(node, 1, status);
  EXPECT_TRUE(line().ends_with("a: clock not synchronised  b: clock not synchronised  and 2 nodes more")) << line();
}

TEST_F(NodeConcerns, TheSummaryTellsOfPageFaultsAndTheNodesRecording) {
  proto::NodeStatus status = warm(60);
  status.minor_faults = 4;
  status.major_faults = 1;
  status.recording = proto::RecordState::kRecording;
  status.recorded = 100;
  status.record_dropped = 7;
  hear("a", 1, status);
  const std::string table = summary_table(session_);
  EXPECT_NE(table.find("page faults in the frame loop: 5, 1 of them with the disk"), std::string::npos) << table;
  EXPECT_NE(table.find("recorded on the node: 100 frames, 7 dropped"), std::string::npos) << table;
}

}  // namespace
}  // namespace srd::host
