// SPDX-License-Identifier: Apache-2.0
// What goes into a strobe and what comes out: frames' stamps, and what light each exposure had.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>

#include "dsp/core/time.hpp"

namespace srd {

// Which exposures get light: repeated exposure by exposure.
struct StrobePattern {
  static constexpr int kMaxLength = 32;
  std::uint32_t bits = 1;  // bit i: exposure i is lit
  int length = 1;

  // "L" lit, "D" dark: "LLLD". Nothing for other letters, more than kMaxLength of them, or no L.
  [[nodiscard]] static constexpr std::optional<StrobePattern> parse(std::string_view text) {
    if (text.empty() || text.size() > kMaxLength) return std::nullopt;
    StrobePattern pattern{0, static_cast<int>(text.size())};
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != 'L' && text[i] != 'D') return std::nullopt;
      if (text[i] == 'L') pattern.bits |= std::uint32_t{1} << i;
    }
    return pattern.bits == 0 ? std::nullopt : std::optional(pattern);
  }
  [[nodiscard]] constexpr bool lit(std::int64_t slot) const {
    const std::int64_t i = slot % length;
    return (bits >> (i < 0 ? i + length : i) & 1) != 0;
  }
  [[nodiscard]] constexpr int lit_count() const { return std::popcount(bits); }
  [[nodiscard]] constexpr bool has_dark() const { return lit_count() < length; }
};

// A frame's stamp as the capturing thread has it.
struct StrobeStamp {
  std::uint64_t sequence = 0;
  std::int64_t time_ns = 0;  // CameraFrame::time_ns
  ClockId clock = ClockId::kMonotonic;
};

// One exposure and its light. Times are of the sensor's clock, so that they compare with frames' stamps.
struct StrobePulse {
  std::int64_t slot = 0;                               // counts exposures; the pattern's place is slot % length
  std::uint64_t sequence = 0;                          // the frame's, as predicted; 0 in trigger mode
  std::int64_t stamp_ns = 0;                           // the frame's, as predicted
  StrobePhase phase = StrobePhase::kUnstrobed;         // lit | dark on purpose | unstrobed: should have been lit, and was not
  std::int64_t planned_on_ns = 0, planned_off_ns = 0;  // of the light, the line's latency included; lit ones only
  std::int64_t on_ns = 0, off_ns = 0;                  // as it was; lit ones only
  [[nodiscard]] std::int64_t middle_ns() const { return on_ns + (off_ns - on_ns) / 2; }
};

}  // namespace srd
