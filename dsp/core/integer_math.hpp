// Integer square root and rounded division: the front end's arithmetic, equal on every machine.
#pragma once

#include <bit>
#include <cstdint>

namespace srd::dsp {

// floor(sqrt(x)).
[[nodiscard]] constexpr std::uint32_t isqrt(std::uint64_t x) {
  if (x == 0) return 0;
  // A power of two not below the root, then Newton from above: monotone, ends at the floor.
  std::uint64_t root = std::uint64_t{1} << ((std::bit_width(x) + 1) / 2);
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
