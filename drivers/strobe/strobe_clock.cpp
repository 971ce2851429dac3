#include "drivers/strobe/strobe_clock.hpp"

#include <cerrno>
#include <ctime>
#include <limits>

namespace srd {

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::int64_t read(clockid_t clock) noexcept {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<std::int64_t>(t.tv_sec) * kSecond + t.tv_nsec;
}

}  // namespace

std::int64_t SystemStrobeClock::now_ns() noexcept { return read(CLOCK_MONOTONIC); }

void SystemStrobeClock::sleep_until(std::int64_t monotonic_ns) noexcept {
  timespec t{};
  t.tv_sec = static_cast<time_t>(monotonic_ns / kSecond);
  t.tv_nsec = static_cast<decltype(t.tv_nsec)>(monotonic_ns % kSecond);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

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
    const std::int64_t before = read(CLOCK_MONOTONIC), there = read(other), after = read(CLOCK_MONOTONIC);
    if (after - before >= narrowest) continue;
    narrowest = after - before;
    offset = there - (before + narrowest / 2);
  }
  return offset;
}

}  // namespace srd
