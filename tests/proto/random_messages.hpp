// SPDX-License-Identifier: Apache-2.0
// Random messages within the bounds of the wire, for property tests. Deterministic in the generator's state.
#pragma once

#include <cmath>
#include <random>
#include <string>

#include "proto/half_float.hpp"
#include "proto/messages.hpp"

namespace srd::proto::testing {

using Generator = std::mt19937_64;

// Small numbers, middling ones and the largest: varints of every length.
inline std::uint64_t any_number(Generator& random, std::uint64_t most = ~std::uint64_t{0}) {
  const std::uint64_t bits = random() >> (random() % 64);
  return most == ~std::uint64_t{0} ? bits : bits % (most + 1);
}
inline std::uint32_t any_u32(Generator& random) { return static_cast<std::uint32_t>(any_number(random, 0xFFFFFFFF)); }
inline float any_float(Generator& random, float least, float most) {
  return std::uniform_real_distribution<float>(least, most)(random);
}

inline NodeId any_node(Generator& random) {
  static constexpr std::string_view kLetters = "abcXYZ019-_.";
  std::string name(static_cast<std::size_t>(1 + random() % NodeId::kMaxLength), 'a');
  for (char& c : name) c = kLetters[static_cast<std::size_t>(random() % kLetters.size())];
  return *NodeId::make(name);
}

inline Stamp any_stamp(Generator& random) {
  return {static_cast<std::int64_t>(any_number(random)), static_cast<ClockId>(random() % 5),
          static_cast<std::int64_t>(any_number(random)), any_number(random)};
}

// Different modes, 1..24.
inline dsp::ModeList any_modes(Generator& random, std::size_t count) {
  std::array<dsp::Mode, dsp::kMaxModes> modes;
  std::size_t n = 0;
  while (n < count) {
    dsp::Mode mode{dsp::Mode::Kind::kCosine, static_cast<std::uint8_t>(random() % 10),
                   static_cast<std::uint8_t>(random() % 10)};
    if (random() % 8 == 0) mode = {random() % 2 == 0 ? dsp::Mode::Kind::kSlopeX : dsp::Mode::Kind::kSlopeY, 0, 0};
    bool there = false;
    for (std::size_t i = 0; i < n; ++i) there = there || modes[i] == mode;
    if (!there) modes[n++] = mode;
  }
  return dsp::ModeList::make(std::span(modes).first(count)).value();
}

inline CoefficientFrame any_frame(Generator& random, int modes = 0) {
  CoefficientFrame frame;
  const auto n = modes != 0 ? static_cast<std::size_t>(modes) : 1 + random() % dsp::kMaxModes;
  frame.stamp = any_stamp(random);
  const auto status = random() % (kFrameStatusCount - 1);
  frame.status = static_cast<FrameStatus>(status < 8 ? status : status + 1);  // 8 is no status
  frame.model = {any_modes(random, static_cast<std::size_t>(n)), any_float(random, 1, 1e4f), any_float(random, 1, 1e4f),
                 any_float(random, -1e3f, 1e3f), any_float(random, -1e3f, 1e3f)};
  frame.refractive_index = any_float(random, 1, 1.6f);
  for (auto plates = random() % (dsp::kMaxLayers + 1); plates > 0; --plates)
    (void)frame.plates.push({any_float(random, 0, 50), any_float(random, 1, 2)});
  frame.centre_x_mm = any_float(random, -500, 500);
  frame.centre_y_mm = any_float(random, -500, 500);
  frame.pattern_x_mm = any_float(random, 0, 1000);
  frame.pattern_y_mm = any_float(random, 0, 1000);
  if (modes != 0 || random() % 4 != 0) {
    frame.coefficients.resize(static_cast<Eigen::Index>(n));
    for (auto& a : frame.coefficients) a = any_float(random, -100, 100);
    if (modes != 0 || random() % 4 != 0) {
      frame.information.size = static_cast<int>(n);
      for (std::size_t j = 0; j < n; ++j) {
        frame.information.scale[j] = std::exp(any_float(random, -20, 20));
        for (std::size_t i = 0; i <= j; ++i)
          frame.information.entries[InformationFactor::index(static_cast<int>(i), static_cast<int>(j))] =
              static_cast<std::int16_t>(i == j ? 1 + random() % 32767 : random());
      }
    }
  }
  if (modes != 0 || random() % 2 == 0) {
    frame.systematic.pose_day = static_cast<std::uint32_t>(random() % 30000);
    if (modes != 0 || random() % 2 == 0) frame.systematic.calibration_day = static_cast<std::uint32_t>(random() % 30000);
  }
  if (frame.has_surface() && frame.systematic.pose_day) {
    const auto any_half = [&] { return float_of(half_of(std::exp(any_float(random, -12, 5)))); };
    frame.systematic.deviation.resize(frame.coefficients.size());
    for (auto& mm : frame.systematic.deviation) mm = any_half();
    frame.systematic.height_mm = any_half();
  }
  frame.metric = static_cast<dsp::Metric>(random() % 3);
  frame.mean_error = any_float(random, 0, 10);
  frame.reprojection_rms_px = any_float(random, 0, 10);
  const auto stop = random() % 10;
  frame.stop = static_cast<dsp::Stop>(stop < 6 ? stop : stop + 10);
  frame.at_bound = random() % 2 == 0;
  frame.iterations = any_u32(random);
  frame.corners_expected = any_u32(random);
  frame.corners_found = any_u32(random);
  frame.corners_used = any_u32(random);
  frame.exposure_us = any_u32(random);
  frame.strobe = static_cast<StrobePhase>(random() % 3);
  frame.dropped_before = any_u32(random);
  frame.source_sequence = any_number(random);
  frame.detection_us = any_u32(random);
  frame.estimation_us = any_u32(random);
  frame.total_us = any_u32(random);
  return frame;
}

template <std::size_t N>
FixedList<SequenceRange, N> any_ranges(Generator& random, std::uint64_t begin, std::uint64_t& end) {
  FixedList<SequenceRange, N> ranges;
  std::uint64_t at = begin;
  for (std::uint64_t i = random() % (N + 1); i > 0; --i) {
    const std::uint64_t from = at + 1 + any_number(random, 1u << 20);
    const std::uint64_t to = from + 1 + any_number(random, 1u << 20);
    ranges.push({from, to});
    at = to;
  }
  end = at + any_number(random, 1000);
  return ranges;
}

inline NodeStatus any_status(Generator& random) {
  NodeStatus status;
  status.stamp = any_stamp(random);
  status.state = static_cast<NodeState>(random() % kNodeStateCount);
  status.capture_hz = any_float(random, 0, 500);
  status.record_hz = any_float(random, 0, 500);
  for (std::uint64_t* count :
       {&status.dropped_by_source, &status.dropped_late, &status.dropped_bad, &status.dropped_transmit, &status.lost,
        &status.resent, &status.held, &status.strobe_late, &status.clock_uncertainty_ns, &status.minor_faults,
        &status.major_faults, &status.recorded, &status.record_dropped, &status.disconnects, &status.bad_stamps})
    *count = any_number(random);
  if (random() % 2 == 0) status.temperature_c = any_float(random, -20, 90);
  if (random() % 2 == 0) status.clock_offset_ns = static_cast<std::int64_t>(any_number(random));
  status.software = *FixedText<15>::make("0.1.0-rc2");
  status.throttled = any_u32(random) & Throttled::kAll;
  status.restarts = any_u32(random);
  status.last_end = *FixedText<95>::make(std::string(static_cast<std::size_t>(random() % 96), 'e'));
  status.clock_state = static_cast<ClockState>(random() % 3);
  status.recording = static_cast<RecordState>(random() % 3);
  std::uint64_t end = 0;
  status.lost_ranges = any_ranges<16>(random, 0, end);
  return status;
}

inline NodeHeader any_header(Generator& random) {
  const std::uint64_t sequence = any_number(random, kMaxSequence);
  return {{any_node(random), random()}, sequence, any_number(random, sequence)};
}

inline Acknowledgement any_acknowledgement(Generator& random) {
  Acknowledgement out;
  out.of = {any_node(random), random()};
  out.session = random();
  out.serial = any_number(random);
  out.first_missing = any_number(random, kMaxSequence / 2);
  out.missing = any_ranges<40>(random, out.first_missing, out.known_end);
  return out;
}

}  // namespace srd::proto::testing
