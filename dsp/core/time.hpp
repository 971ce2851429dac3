// SPDX-License-Identifier: Apache-2.0
// Whose time a number is, and which light made an image. Numbers are on the wire and in files: never reuse one.
#pragma once

#include <cstdint>

namespace srd {

enum class ClockId : std::uint8_t { kUnknown = 0, kMonotonic = 1, kRealtime = 2, kBoottime = 3, kRecording = 4 };

enum class StrobePhase : std::uint8_t { kUnstrobed = 0, kLit = 1, kDark = 2 };

[[nodiscard]] constexpr const char* to_string(ClockId clock) {
  switch (clock) {
    case ClockId::kUnknown: return "unknown";
    case ClockId::kMonotonic: return "monotonic";
    case ClockId::kRealtime: return "realtime";
    case ClockId::kBoottime: return "boottime";
    case ClockId::kRecording: return "recording";
  }
  return "unknown";
}

}  // namespace srd
