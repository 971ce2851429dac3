// SPDX-License-Identifier: Apache-2.0
// Sine and cosine in whole numbers, equal on every machine.
#pragma once

#include <cstdint>
#include <numbers>

namespace srd::dsp {

struct SineCosine {
  std::int32_t sine = 0, cosine = 0;  // Q30
};

// turn: the angle as a fraction of 2^32 of a full turn; it wraps by itself. Errors below 6e-9.
[[nodiscard]] constexpr SineCosine sin_cos_of_turn(std::uint32_t turn) {
  constexpr std::int64_t kOne = std::int64_t{1} << 30;
  constexpr auto kHalfPi = static_cast<std::int64_t>(std::numbers::pi / 2 * static_cast<double>(kOne) + 0.5);
  const std::uint32_t quarter = (turn + (1u << 29)) >> 30;              // nearest quarter turn, 0 to 4
  const auto rest = static_cast<std::int32_t>(turn - (quarter << 30));  // |rest| <= 2^29
  const std::int64_t x = (rest * kHalfPi) >> 30;                        // |x| <= pi/4, Q30
  const std::int64_t x2 = (x * x) >> 30;
  // Taylor, nested; every factor lies in (0, 1], so products stay below 2^60. The first term left out is
  // (pi/4)^11/11! = 1.8e-9.
  const auto nest = [&](std::int64_t divisor, std::int64_t inner) { return kOne - ((x2 * inner) >> 30) / divisor; };
  const std::int64_t sine = (x * nest(6, nest(20, nest(42, nest(72, kOne))))) >> 30;
  const std::int64_t cosine = nest(2, nest(12, nest(30, nest(56, nest(90, kOne)))));
  const auto s = static_cast<std::int32_t>(sine), c = static_cast<std::int32_t>(cosine);
  switch (quarter & 3) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

}  // namespace srd::dsp
