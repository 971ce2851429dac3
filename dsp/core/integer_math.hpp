// SPDX-License-Identifier: Apache-2.0
// Integer square root and rounded division: the front end's arithmetic, equal on every machine.
#pragma once

#include <bit>
#include <cstdint>

namespace srd::dsp {

// floor(sqrt(x)).
[[nodiscard]] constexpr std::uint32_t isqrt(std::uint64_t x) {
  if (x == 0) return 0;
  // Newton from above: monotone, ends at the floor. Its first step from a power of two near the root needs no division:
  // (2^h + x / 2^h) / 2 is not below the root and at most a sixteenth above it.
  const int h = static_cast<int>(std::bit_width(x)) / 2;
  std::uint64_t root = ((std::uint64_t{1} << h) + (x >> h)) / 2 + 1;
  for (;;) {
    const std::uint64_t next = (root + x / root) / 2;
    if (next >= root) return static_cast<std::uint32_t>(root);
    root = next;
  }
}

// a / b to nearest, halves away from zero; b > 0.
[[nodiscard]] constexpr std::int64_t divide_rounded(std::int64_t a, std::int64_t b) {
  return a >= 0 ? (a + b / 2) / b : -((-a + b / 2) / b);
}

// x * 2^-shift to nearest, halves up; shift >= 1.
[[nodiscard]] constexpr std::int64_t shift_rounded(std::int64_t x, int shift) {
  return (x + (std::int64_t{1} << (shift - 1))) >> shift;
}

}  // namespace srd::dsp
