// SPDX-License-Identifier: Apache-2.0
// A camera's frames in the light of a measurement.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>

#include "firmware/strobe/strobe.hpp"

namespace srd::firmware {

// Where a strobe lights them, only frames with its light are to be looked at: those that are dark on purpose, and those
// before it is in step, tell nothing of light and pattern.
class LitFrames {
 public:
  // strobe: started; null: the light is somebody else's.
  LitFrames(Camera& camera, Strobe* strobe, const StrobeSection& section)
      : camera_(camera), strobe_(strobe), mode_(section.mode), strobed_(strobe != nullptr && !section.line.empty()) {}

  Capture next(CameraFrame& frame, Nanoseconds timeout) {
    const Capture got = camera_.next(frame, timeout);
    if (got == Capture::kFrame && strobe_ != nullptr) {
      strobe_->captured(frame);
      strobe_->label(frame);
    }
    return got;
  }
  void give_back(const CameraFrame& frame) { camera_.give_back(frame); }
  [[nodiscard]] bool lit(const CameraFrame& frame) const { return !strobed_ || frame.strobe == StrobePhase::kLit; }

  // Until the strobe is in step: the stamps that its phase lock needs, and as many for stamps that it cannot use.
  [[nodiscard]] std::chrono::milliseconds time_to_light(double rate_hz) const {
    if (!strobed_ || !(rate_hz > 0)) return std::chrono::milliseconds(0);
    return std::chrono::milliseconds(std::llround(2e3 * (PhaseLock::kWindow + PhaseLock::kLockFrames) / rate_hz));
  }
  // "none of 40 frames has the strobe's light: acquiring, 0 pulses, 0 skipped"
  [[nodiscard]] std::string none_of(std::uint64_t frames) const {
    std::string text = "none of " + std::to_string(frames) + " frames has the strobe's light";
    if (strobe_ == nullptr) return text;
    const StrobeCounters& counters = strobe_->counters();
    text += ": ";
    if (mode_ == StrobeMode::kFollow) text += std::string(to_string(counters.lock.load(std::memory_order_relaxed))) + ", ";
    return text + std::to_string(counters.pulses.load(std::memory_order_relaxed)) + " pulses, " +
           std::to_string(counters.skipped.load(std::memory_order_relaxed)) + " skipped";
  }

 private:
  Camera& camera_;
  Strobe* strobe_;
  StrobeMode mode_;
  bool strobed_;
};

}  // namespace srd::firmware
