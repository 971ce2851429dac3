// SPDX-License-Identifier: Apache-2.0
// 64-bit frame numbers out of a driver's 32-bit ones, across their wrap and across reconnects. One thread.
#pragma once

#include <algorithm>
#include <cstdint>

namespace srd {

class FrameSequence {
 public:
  FrameSequence() = default;
  // period_ns: between two frames; 0: unknown, then a reconnect counts as one step.
  explicit FrameSequence(std::int64_t period_ns) : period_ns_(period_ns) {}

  // raw: the driver's number; time_ns: of a clock that goes on while the device is away.
  // A number that moves less than half its range ahead moves as far; one that stays or falls back (drivers that do not
  // count, or start again) moves by the time that passed, and by one at least.
  [[nodiscard]] std::uint64_t next(std::uint32_t raw, std::int64_t time_ns) noexcept {
    if (!any_) {
      last_ = raw;
    } else {
      const std::uint32_t ahead = raw - raw_;
      const bool moved = ahead != 0 && ahead < 0x8000'0000U;
      last_ += moved && !restarted_ ? ahead : periods(time_ns - time_ns_);
    }
    any_ = true;
    restarted_ = false;
    raw_ = raw;
    time_ns_ = time_ns;
    return last_;
  }
  // A frame that the driver gave no number: the one after the last.
  [[nodiscard]] std::uint64_t next_unnumbered(std::int64_t time_ns) noexcept { return next(raw_ + 1, time_ns); }
  // The device was opened again: its next number has nothing to do with the last one.
  void restart() noexcept { restarted_ = true; }
  [[nodiscard]] std::uint64_t last() const { return last_; }

 private:
  [[nodiscard]] std::uint64_t periods(std::int64_t elapsed_ns) const noexcept {
    if (period_ns_ <= 0 || elapsed_ns <= 0) return 1;
    return static_cast<std::uint64_t>(std::max<std::int64_t>(1, (elapsed_ns + period_ns_ / 2) / period_ns_));
  }

  std::int64_t period_ns_ = 0;
  std::uint64_t last_ = 0;
  std::uint32_t raw_ = 0;
  std::int64_t time_ns_ = 0;
  bool any_ = false, restarted_ = false;
};

}  // namespace srd
