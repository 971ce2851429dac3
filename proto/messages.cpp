// SPDX-License-Identifier: Apache-2.0
#include "proto/messages.hpp"

#include <algorithm>
#include <cmath>

namespace srd::proto {
namespace {

constexpr float kMinLength = 1e-3f, kMaxLength = 1e6f;  // mm
constexpr float kMaxPlate = 1000, kMaxPlateIndex = 3;   // mm; as configurations and model files have it

bool finite(float x) { return std::isfinite(x); }
bool positive(float x) { return finite(x) && x > 0; }
bool is_length(float x) { return x >= kMinLength && x <= kMaxLength; }
bool is_place(float x) { return x >= -kMaxLength && x <= kMaxLength; }
bool not_negative(float x) { return finite(x) && x >= 0; }

bool valid(const dsp::Layer<float>& plate) {
  return plate.thickness >= 0 && plate.thickness <= kMaxPlate && plate.index >= 1 && plate.index <= kMaxPlateIndex;
}

bool valid(const Stamp& stamp) { return stamp.clock <= ClockId::kRecording; }

template <std::size_t N>
bool ascending(const FixedList<SequenceRange, N>& ranges, std::uint64_t begin, std::uint64_t end) {
  std::uint64_t at = begin;
  for (const SequenceRange& range : ranges) {
    if (range.begin < at || range.end <= range.begin || range.end > end) return false;
    at = range.end + 1;  // apart: ranges that touch are one
  }
  return true;
}

bool valid(FrameStatus status) { return static_cast<int>(status) < kFrameStatusCount && static_cast<int>(status) != 8; }

bool valid(dsp::Stop stop) { return stop <= dsp::Stop::kNoProgress || (dsp::failed(stop) && stop <= dsp::Stop::kOutOfDomain); }

bool valid(const InformationFactor& factor) {
  for (int j = 0; j < factor.size; ++j)
    if (!positive(factor.scale[static_cast<std::size_t>(j)]) || factor.entries[InformationFactor::index(j, j)] <= 0)
      return false;
  return factor.size >= 0 && factor.size <= dsp::kMaxModes;
}

bool is_deviation(float x) { return x >= 0 && x <= SystematicErrors::kMost; }

bool valid(const SystematicErrors& errors) {
  return std::all_of(errors.deviation.begin(), errors.deviation.end(), is_deviation) && is_deviation(errors.height_mm) &&
         (errors.pose_day || (errors.deviation.size() == 0 && !errors.calibration_day)) &&
         errors.pose_day.value_or(0) <= SystematicErrors::kLastDay &&
         errors.calibration_day.value_or(0) <= SystematicErrors::kLastDay;
}

}  // namespace

const char* to_string(FrameStatus status) {
  switch (status) {
    case FrameStatus::kOk: return "ok";
    case FrameStatus::kSearching: return "searching";
    case FrameStatus::kLost: return "lost";
    case FrameStatus::kBadFrame: return "bad_frame";
    case FrameStatus::kTooFewCorners: return "too_few_corners";
    case FrameStatus::kNotConverged: return "not_converged";
    case FrameStatus::kFailed: return "failed";
    case FrameStatus::kAmbiguous: return "ambiguous";
    case FrameStatus::kDark: return "dark";
    case FrameStatus::kPoorFit: return "poor_fit";
    case FrameStatus::kInconsistent: return "inconsistent";
    case FrameStatus::kInterlaced: return "interlaced";
  }
  return "unknown";
}

const char* to_string(NodeState state) {
  switch (state) {
    case NodeState::kStarting: return "starting";
    case NodeState::kSearching: return "searching";
    case NodeState::kTracking: return "tracking";
    case NodeState::kLost: return "lost";
    case NodeState::kStopping: return "stopping";
  }
  return "unknown";
}

const char* throttled_text(std::uint32_t throttled) {
  if ((throttled & Throttled::kUnderVoltage) != 0) return "under-voltage";
  if ((throttled & Throttled::kThrottled) != 0) return "throttled";
  if ((throttled & Throttled::kTemperatureLimit) != 0) return "at its temperature limit";
  if ((throttled & Throttled::kCapped) != 0) return "frequency capped";
  return "";
}

bool valid(const NodeHeader& header) {
  return !header.from.node.view().empty() && header.sequence <= kMaxSequence && header.oldest_held <= header.sequence;
}

bool valid(const CoefficientFrame& frame) {
  const auto n = frame.model.modes.size();
  const auto coefficients = static_cast<int>(frame.coefficients.size());
  return valid(frame.stamp) && valid(frame.status) && n > 0 && is_length(frame.model.lx) && is_length(frame.model.ly) &&
         is_place(frame.model.x0) && is_place(frame.model.y0) && frame.refractive_index >= 1 && frame.refractive_index <= 2 &&
         std::all_of(frame.plates.begin(), frame.plates.end(), [](const auto& plate) { return valid(plate); }) &&
         is_place(frame.centre_x_mm) && is_place(frame.centre_y_mm) && not_negative(frame.pattern_x_mm) &&
         frame.pattern_x_mm <= kMaxLength && not_negative(frame.pattern_y_mm) && frame.pattern_y_mm <= kMaxLength &&
         (coefficients == 0 || coefficients == n) && frame.coefficients.allFinite() && valid(frame.information) &&
         (frame.information.size == 0 || frame.information.size == coefficients) &&
         (frame.systematic.deviation.size() == 0 || frame.systematic.deviation.size() == coefficients) &&
         valid(frame.systematic) && frame.metric <= dsp::Metric::kCollinearity && not_negative(frame.mean_error) &&
         not_negative(frame.reprojection_rms_px) && valid(frame.stop) && frame.strobe <= StrobePhase::kDark;
}

bool valid(const NodeStatus& status) {
  return valid(status.stamp) && static_cast<int>(status.state) < kNodeStateCount && not_negative(status.capture_hz) &&
         not_negative(status.record_hz) && !std::isinf(status.temperature_c) && (status.throttled & ~Throttled::kAll) == 0 &&
         status.clock_state <= ClockState::kUnsynchronised && status.recording <= RecordState::kStopped &&
         ascending(status.lost_ranges, 0, kMaxSequence);
}

bool valid(const Hello& hello) { return valid(hello.stamp); }

bool valid(const Acknowledgement& acknowledgement) {
  return !acknowledgement.of.node.view().empty() && acknowledgement.first_missing <= acknowledgement.known_end &&
         acknowledgement.known_end <= kMaxSequence &&
         ascending(acknowledgement.missing, acknowledgement.first_missing, acknowledgement.known_end);
}

}  // namespace srd::proto
