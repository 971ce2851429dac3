// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "proto/check.hpp"
#include "proto/host_codec.hpp"
#include "proto/node_codec.hpp"
#include "tests/proto/random_messages.hpp"

namespace srd::proto {
namespace {

using testing::Generator;

template <class Content>
std::vector<std::uint8_t> datagram_of(const NodeHeader& header, const Content& content) {
  std::vector<std::uint8_t> buffer(kMaxDatagram);
  const auto size = encode(header.from, header.sequence, content, buffer);
  if (!size) return {};
  buffer.resize(seal(buffer, *size, header.oldest_held));
  return buffer;
}

void expect_same(const CoefficientFrame& a, const CoefficientFrame& b) {
  RC_ASSERT(a.stamp == b.stamp);
  RC_ASSERT(a.status == b.status);
  RC_ASSERT(a.model.modes == b.model.modes);
  RC_ASSERT(a.model.lx == b.model.lx && a.model.ly == b.model.ly && a.model.x0 == b.model.x0 && a.model.y0 == b.model.y0);
  RC_ASSERT(a.refractive_index == b.refractive_index);
  RC_ASSERT(a.plates.size() == b.plates.size());
  for (std::size_t i = 0; i < a.plates.size(); ++i)
    RC_ASSERT(a.plates[i].thickness == b.plates[i].thickness && a.plates[i].index == b.plates[i].index);
  RC_ASSERT(a.centre_x_mm == b.centre_x_mm && a.centre_y_mm == b.centre_y_mm);
  RC_ASSERT(a.pattern_x_mm == b.pattern_x_mm && a.pattern_y_mm == b.pattern_y_mm);
  RC_ASSERT(a.coefficients.size() == b.coefficients.size());
  for (Eigen::Index i = 0; i < a.coefficients.size(); ++i) RC_ASSERT(a.coefficients[i] == b.coefficients[i]);
  RC_ASSERT(a.information == b.information);
  RC_ASSERT(a.systematic.deviation.size() == b.systematic.deviation.size());
  for (Eigen::Index i = 0; i < a.systematic.deviation.size(); ++i)
    RC_ASSERT(a.systematic.deviation[i] == b.systematic.deviation[i]);
  RC_ASSERT(a.systematic.height_mm == b.systematic.height_mm && a.systematic.pose_day == b.systematic.pose_day);
  RC_ASSERT(a.systematic.calibration_day == b.systematic.calibration_day);
  RC_ASSERT(a.metric == b.metric && a.mean_error == b.mean_error && a.reprojection_rms_px == b.reprojection_rms_px);
  RC_ASSERT(a.stop == b.stop && a.at_bound == b.at_bound && a.iterations == b.iterations);
  RC_ASSERT(a.corners_expected == b.corners_expected && a.corners_found == b.corners_found && a.corners_used == b.corners_used);
  RC_ASSERT(a.exposure_us == b.exposure_us && a.strobe == b.strobe && a.dropped_before == b.dropped_before);
  RC_ASSERT(a.source_sequence == b.source_sequence);
  RC_ASSERT(a.detection_us == b.detection_us && a.estimation_us == b.estimation_us && a.total_us == b.total_us);
}

TEST(Codec, FramesComeBackAsTheyWere) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Generator random(seed);
    const NodeHeader header = testing::any_header(random);
    const CoefficientFrame frame = testing::any_frame(random);
    const auto datagram = datagram_of(header, frame);
    RC_ASSERT(!datagram.empty() && datagram.size() <= kMaxDatagram);
    const auto back = decode_node_datagram(datagram);
    RC_ASSERT(back.has_value());
    RC_ASSERT(back->header == header);
    RC_ASSERT(std::holds_alternative<CoefficientFrame>(back->content));
    expect_same(std::get<CoefficientFrame>(back->content), frame);
  }));
}

TEST(Codec, EveryStatusHasAWordAndPasses) {
  constexpr int kGivenUp = 8;  // a number that no status has any more
  Generator random(7);
  std::set<std::string> words;
  for (int i = 0; i < kFrameStatusCount; ++i) {
    CoefficientFrame frame = testing::any_frame(random);
    frame.status = static_cast<FrameStatus>(i);
    EXPECT_EQ(valid(frame), i != kGivenUp) << i;
    if (i != kGivenUp) words.insert(to_string(frame.status));
  }
  EXPECT_EQ(words.size(), static_cast<std::size_t>(kFrameStatusCount - 1));
  EXPECT_FALSE(words.contains("unknown"));
}

TEST(Codec, StatusComesBackAsItWas) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Generator random(seed);
    const NodeHeader header = testing::any_header(random);
    const NodeStatus a = testing::any_status(random);
    const auto datagram = datagram_of(header, a);
    RC_ASSERT(!datagram.empty());
    const auto back = decode_node_datagram(datagram);
    RC_ASSERT(back.has_value());
    RC_ASSERT(back->header == header);
    RC_ASSERT(std::holds_alternative<NodeStatus>(back->content));
    const auto& b = std::get<NodeStatus>(back->content);
    RC_ASSERT(a.stamp == b.stamp && a.state == b.state && a.capture_hz == b.capture_hz && a.record_hz == b.record_hz);
    RC_ASSERT(a.dropped_by_source == b.dropped_by_source && a.dropped_late == b.dropped_late);
    RC_ASSERT(a.dropped_bad == b.dropped_bad && a.dropped_transmit == b.dropped_transmit);
    RC_ASSERT(a.lost == b.lost && a.resent == b.resent && a.held == b.held && a.strobe_late == b.strobe_late);
    RC_ASSERT(a.temperature_c == b.temperature_c || (std::isnan(a.temperature_c) && std::isnan(b.temperature_c)));
    RC_ASSERT(a.clock_offset_ns == b.clock_offset_ns && a.clock_uncertainty_ns == b.clock_uncertainty_ns);
    RC_ASSERT(a.software == b.software);
    RC_ASSERT(a.throttled == b.throttled && a.restarts == b.restarts && a.last_end == b.last_end);
    RC_ASSERT(a.clock_state == b.clock_state && a.minor_faults == b.minor_faults && a.major_faults == b.major_faults);
    RC_ASSERT(a.recording == b.recording && a.recorded == b.recorded && a.record_dropped == b.record_dropped);
    RC_ASSERT(a.disconnects == b.disconnects);
    RC_ASSERT(a.bad_stamps == b.bad_stamps);
    RC_ASSERT(a.lost_ranges == b.lost_ranges);
  }));
}

TEST(Codec, AcknowledgementsComeBackAsTheyWere) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Generator random(seed);
    const Acknowledgement acknowledgement = testing::any_acknowledgement(random);
    const auto datagram = encode_datagram(acknowledgement);
    RC_ASSERT(!datagram.empty() && datagram.size() <= kMaxDatagram);
    const auto back = decode_acknowledgement(datagram);
    RC_ASSERT(back.has_value());
    RC_ASSERT(*back == acknowledgement);
  }));
}

// Every varint at its longest, every list full.
TEST(Codec, TheLargestOfEveryMessageFitsADatagram) {
  Generator random(4);
  constexpr std::uint32_t kMax = 0xFFFFFFFF;
  const NodeHeader header{{*NodeId::make(std::string(31, 'n')), ~std::uint64_t{0}}, kMaxSequence, kMaxSequence};
  const Stamp stamp{-1, ClockId::kRecording, -1, ~std::uint64_t{0}};
  CoefficientFrame frame = testing::any_frame(random, dsp::kMaxModes);
  frame.stamp = stamp;
  frame.status = FrameStatus::kPoorFit;
  frame.metric = dsp::Metric::kCollinearity;
  frame.stop = dsp::Stop::kOutOfDomain;
  frame.at_bound = true;
  frame.strobe = StrobePhase::kDark;
  frame.source_sequence = ~std::uint64_t{0};
  while (frame.plates.push({12, 1.49f})) {}
  frame.systematic.deviation.setConstant(frame.coefficients.size(), 1);
  frame.systematic.pose_day = SystematicErrors::kLastDay;
  frame.systematic.calibration_day = SystematicErrors::kLastDay;
  for (std::uint32_t* count :
       {&frame.iterations, &frame.corners_expected, &frame.corners_found, &frame.corners_used, &frame.exposure_us,
        &frame.dropped_before, &frame.detection_us, &frame.estimation_us, &frame.total_us})
    *count = kMax;
  const auto large = datagram_of(header, frame);
  EXPECT_GT(large.size(), 1000u);
  constexpr std::size_t kTagIsLonger = kMostEndBytes - kCheckBytes;
  EXPECT_LE(large.size() + kTagIsLonger, kMaxDatagram);
  EXPECT_TRUE(decode_node_datagram(large).has_value());
  RecordProperty("largest_frame_bytes", static_cast<int>(large.size()));
  // What a spill makes room for.
  std::array<std::uint8_t, kMaxEncoded> encoded;
  const auto bytes = encode(header.from, header.sequence, frame, encoded);
  ASSERT_TRUE(bytes.ok());
  EXPECT_EQ(most_frame_bytes(frame.model.modes), *bytes);

  NodeStatus status = testing::any_status(random);
  status.stamp = stamp;
  status.lost_ranges.clear();
  for (std::uint64_t i = 0; i < 16; ++i)
    status.lost_ranges.push({kMaxSequence - 1000 + 3 * i, kMaxSequence - 1000 + 3 * i + 2});
  for (std::uint64_t* count :
       {&status.dropped_by_source, &status.dropped_late, &status.dropped_bad, &status.dropped_transmit, &status.lost,
        &status.resent, &status.held, &status.strobe_late, &status.clock_uncertainty_ns, &status.minor_faults,
        &status.major_faults, &status.recorded, &status.record_dropped, &status.disconnects, &status.bad_stamps})
    *count = ~std::uint64_t{0};
  status.temperature_c = -1;
  status.clock_offset_ns = -1;
  status.software = *FixedText<15>::make(std::string(15, 'v'));
  status.throttled = Throttled::kAll;
  status.restarts = kMax;
  status.last_end = *FixedText<95>::make(std::string(95, 'e'));
  const auto largest_status = datagram_of(header, status);
  EXPECT_GT(largest_status.size(), 700u);
  EXPECT_LE(largest_status.size() + kTagIsLonger, kMaxDatagram);
  EXPECT_TRUE(decode_node_datagram(largest_status).has_value());
  RecordProperty("largest_status_bytes", static_cast<int>(largest_status.size()));

  Acknowledgement acknowledgement;
  acknowledgement.of = header.from;
  acknowledgement.session = acknowledgement.serial = ~std::uint64_t{0};
  const std::uint64_t step = kMaxSequence / 100;
  for (std::uint64_t i = 0; i < 40; ++i) acknowledgement.missing.push({step * (2 * i + 1), step * (2 * i + 2)});
  acknowledgement.known_end = kMaxSequence;
  const auto answer = encode_datagram(acknowledgement);
  EXPECT_LE(answer.size() + kTagIsLonger, kMaxDatagram);
  EXPECT_EQ(decode_acknowledgement(answer), acknowledgement);
}

TEST(Codec, ATwelveParameterFrameIsSmall) {
  Generator random(5);
  CoefficientFrame frame = testing::any_frame(random, 12);
  const NodeHeader header{{*NodeId::make("flume-camera-1"), random()}, 100000, 99000};
  frame.plates.clear();
  frame.systematic = {};
  const std::size_t without = datagram_of(header, frame).size();
  EXPECT_LE(without, 480u);
  ASSERT_TRUE(frame.plates.push({12, 1.49f}));
  frame.systematic.deviation.setConstant(12, 1);
  frame.systematic.pose_day = frame.systematic.calibration_day = 20'000;
  const std::size_t with = datagram_of(header, frame).size();
  // 13 half floats and two dates, with their field numbers 39 bytes; a plate's two numbers, 12.
  EXPECT_LE(with - without, 51u);
  RecordProperty("twelve_parameter_bytes", static_cast<int>(with));
}

TEST(Codec, WhatBreaksABoundIsNotSent) {
  Generator random(6);
  std::vector<std::uint8_t> buffer(kMaxDatagram);
  const BootId from{*NodeId::make("n"), 1};
  const auto error_of = [&](const auto& message) {
    const auto size = encode(from, 0, message, buffer);
    return size.ok() ? std::optional<Errc>{} : std::optional<Errc>{size.error()};
  };
  const CoefficientFrame good = testing::any_frame(random, 3);
  EXPECT_EQ(error_of(good), std::nullopt);
  CoefficientFrame bad = good;
  bad.coefficients[1] = std::nanf("");
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  bad = good;
  bad.model.modes = dsp::ModeList{};
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  bad = good;
  bad.model.lx = 0;
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  bad = good;
  bad.refractive_index = std::nanf("");
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  for (const dsp::Layer<float> plate :
       {dsp::Layer<float>{-1, 1.49f}, {12, 0.9f}, {12, std::nanf("")}, {std::nanf(""), 1.49f}}) {
    bad = good;
    bad.plates.clear();
    ASSERT_TRUE(bad.plates.push(plate));
    EXPECT_EQ(error_of(bad), Errc::kInvalidArgument) << plate.thickness << ", " << plate.index;
  }
  bad = good;
  bad.coefficients.resize(2);
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  bad = good;
  bad.information.entries[InformationFactor::index(2, 2)] = 0;
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  bad = good;
  bad.systematic.deviation.resize(2);
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  bad = good;
  bad.systematic.deviation[1] = std::nanf("");
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  bad = good;
  bad.systematic.pose_day.reset();
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  bad = good;
  bad.systematic.height_mm = 65505;
  EXPECT_EQ(error_of(bad), Errc::kInvalidArgument);
  NodeStatus status = testing::any_status(random);
  EXPECT_EQ(error_of(status), std::nullopt);
  status.throttled = 0x10;
  EXPECT_EQ(error_of(status), Errc::kInvalidArgument);
  status.throttled = 0;
  status.clock_state = static_cast<ClockState>(3);
  EXPECT_EQ(error_of(status), Errc::kInvalidArgument);
  status.clock_state = ClockState::kUnknown;
  status.recording = static_cast<RecordState>(3);
  EXPECT_EQ(error_of(status), Errc::kInvalidArgument);
  CoefficientFrame retired = good;
  retired.status = static_cast<FrameStatus>(8);
  EXPECT_EQ(error_of(retired), Errc::kInvalidArgument);
  EXPECT_EQ(encode(BootId{}, 0, good, buffer).error(), Errc::kInvalidArgument);
  EXPECT_EQ(encode(from, 0, good, std::span(buffer).first(20)).error(), Errc::kTooSmall);
  Acknowledgement acknowledgement = testing::any_acknowledgement(random);
  acknowledgement.known_end = acknowledgement.first_missing - 1;
  EXPECT_TRUE(encode_datagram(acknowledgement).empty());
}

TEST(Codec, CheckIsCrc32c) {
  const std::string_view digits = "123456789";
  EXPECT_EQ(crc32c(0, {reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()}), 0xE3069283u);
}

TEST(Codec, NodeNamesAreSafeInFilesAndTables) {
  EXPECT_TRUE(NodeId::make("flume-1_a.b").has_value());
  for (const char* name : {"", "a,b", "a b", "a\n", "a/b", "\"", "\xC3\xA4", "12345678901234567890123456789012"})
    EXPECT_FALSE(NodeId::make(name).has_value()) << name;
}

}  // namespace
}  // namespace srd::proto
