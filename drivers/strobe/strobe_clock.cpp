// SPDX-License-Identifier: Apache-2.0
#include "drivers/strobe/strobe_clock.hpp"

#include <limits>

#include "drivers/support/system_clock.hpp"

namespace srd {

std::int64_t SystemStrobeClock::now_ns() noexcept { return clock_ns(CLOCK_MONOTONIC); }

void SystemStrobeClock::sleep_until(std::int64_t monotonic_ns) noexcept { sleep_until_ns(monotonic_ns); }

std::int64_t SystemStrobeClock::offset_ns(ClockId clock) noexcept {
  clockid_t other = CLOCK_MONOTONIC;
  if (clock == ClockId::kRealtime)
    other = CLOCK_REALTIME;
  else if (clock == ClockId::kBoottime)
    other = CLOCK_BOOTTIME;
  else
    return 0;
  // The narrowest of three pairs of readings: an interrupt between them would look like an offset.
  std::int64_t offset = 0, narrowest = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < 3; ++i) {
    const std::int64_t before = clock_ns(CLOCK_MONOTONIC), there = clock_ns(other), after = clock_ns(CLOCK_MONOTONIC);
    if (after - before >= narrowest) continue;
    narrowest = after - before;
    offset = there - (before + narrowest / 2);
  }
  return offset;
}

}  // namespace srd
