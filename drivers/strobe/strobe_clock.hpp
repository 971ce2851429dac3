// SPDX-License-Identifier: Apache-2.0
// The time that a strobe keeps and sleeps by; an interface, so that a test can run a whole strobe in simulated time.
#pragma once

#include <cstdint>

#include "dsp/core/time.hpp"

namespace srd {

class StrobeClock {
 public:
  virtual ~StrobeClock() = default;
  [[nodiscard]] virtual std::int64_t now_ns() noexcept = 0;  // CLOCK_MONOTONIC
  // Returns at or after that time; at once when it is over.
  virtual void sleep_until(std::int64_t monotonic_ns) noexcept = 0;
  // What that clock shows less what CLOCK_MONOTONIC shows. 0 for clocks that are none of this board's.
  [[nodiscard]] virtual std::int64_t offset_ns(ClockId clock) noexcept = 0;
};

// The board's own: clock_nanosleep on absolute times.
class SystemStrobeClock final : public StrobeClock {
 public:
  [[nodiscard]] std::int64_t now_ns() noexcept override;
  void sleep_until(std::int64_t monotonic_ns) noexcept override;
  // To within half the time between two readings of a clock, some 50 ns.
  [[nodiscard]] std::int64_t offset_ns(ClockId clock) noexcept override;
};

}  // namespace srd
