// SPDX-License-Identifier: Apache-2.0
// Whether the wall clock follows a reference, and how well: what the kernel knows from chrony, systemd-timesyncd or ptp.
#pragma once

#include <sys/timex.h>

#include <cstdint>
#include <optional>

#include "proto/messages.hpp"

namespace srd::firmware {

struct ClockHealth {
  proto::ClockState state = proto::ClockState::kUnknown;
  std::optional<std::int64_t> offset_ns;  // still to be corrected, of a synchronised clock
  std::uint64_t uncertainty_ns = 0;       // bound of its error; 0: not known
};

// What adjtimex gave: its return value and its answer.
[[nodiscard]] inline ClockHealth clock_health(int state, const timex& answer) {
  ClockHealth health;
  if (state < 0) return health;
  if (state == TIME_ERROR || (answer.status & STA_UNSYNC) != 0) {
    health.state = proto::ClockState::kUnsynchronised;
    return health;
  }
  health.state = proto::ClockState::kSynchronised;
  health.offset_ns = static_cast<std::int64_t>(answer.offset) * ((answer.status & STA_NANO) != 0 ? 1 : 1000);
  health.uncertainty_ns = static_cast<std::uint64_t>(answer.maxerror) * 1000;
  return health;
}

[[nodiscard]] inline ClockHealth read_clock_health() noexcept {
  timex answer{};  // modes 0: only asks
  const int state = ::adjtimex(&answer);
  return clock_health(state, answer);
}

}  // namespace srd::firmware
