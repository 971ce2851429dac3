// SPDX-License-Identifier: Apache-2.0
// Per-frame time budget, given to the solver as a callback, since dsp/ has no clock. One thread per object.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <utility>

namespace srd::firmware {

class FrameDeadline {
 public:
  using Clock = std::function<std::int64_t()>;  // ns, monotonic

  explicit FrameDeadline(std::int64_t limit_us, Clock clock = steady_ns)
      : limit_ns_(1000 * limit_us), clock_(std::move(clock)) {}

  // The frame's processing begins.
  void start() { begin_ns_ = clock_(); }
  [[nodiscard]] bool passed() const { return clock_() - begin_ns_ >= limit_ns_; }
  // As dsp::EstimatorOptions takes it; self: a FrameDeadline.
  [[nodiscard]] static bool ask(void* self) { return static_cast<const FrameDeadline*>(self)->passed(); }

 private:
  [[nodiscard]] static std::int64_t steady_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  std::int64_t limit_ns_;
  Clock clock_;
  std::int64_t begin_ns_ = 0;
};

}  // namespace srd::firmware
