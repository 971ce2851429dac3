// SPDX-License-Identifier: Apache-2.0
// The system's clocks in nanoseconds. No heap; any thread.
#pragma once

#include <time.h>

#include <cerrno>
#include <cstdint>

namespace srd {

[[nodiscard]] inline std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec time{};
  ::clock_gettime(clock, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

// ns >= 0.
[[nodiscard]] inline timespec timespec_of(std::int64_t ns) noexcept {
  timespec time{};
  time.tv_sec = static_cast<time_t>(ns / 1'000'000'000);
  time.tv_nsec = static_cast<decltype(time.tv_nsec)>(ns % 1'000'000'000);
  return time;
}

// CLOCK_MONOTONIC; signals do not end it.
inline void sleep_until_ns(std::int64_t monotonic_ns) noexcept {
  const timespec until = timespec_of(monotonic_ns);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {}
}

}  // namespace srd
