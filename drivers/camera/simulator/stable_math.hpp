// SPDX-License-Identifier: Apache-2.0
// exp, the normal distribution and random bits that are the same to the last bit on every machine: made of
// IEEE additions, products and quotients alone, where libm may differ from one C library to the next.
#pragma once

#include <bit>
#include <cstdint>

namespace srd::stable {

// e^x for -700 <= x <= 0, relative error below 1e-15.
[[nodiscard]] constexpr double exp_negative(double x) {
  constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33;
  const auto k = static_cast<std::int64_t>(x / (kLn2High + kLn2Low) - 0.5);  // towards zero: nearest for x <= 0
  const double r = (x - static_cast<double>(k) * kLn2High) - static_cast<double>(k) * kLn2Low;
  double sum = 1;
  for (int n = 13; n > 0; --n) sum = 1 + sum * r / n;
  return sum * std::bit_cast<double>(static_cast<std::uint64_t>(1023 + k) << 52);
}

// Probability that a normal deviate is below z, minus 1/2; |z| <= 8. Abramowitz & Stegun 26.2.11: all terms
// positive.
[[nodiscard]] constexpr double normal_cdf_half(double z) {
  constexpr double kInverseSqrt2Pi = 0.39894228040143267794;
  double term = z, sum = z;
  for (int n = 1; n < 200; ++n) {
    term *= z * z / (2 * n + 1);
    const double next = sum + term;
    if (next == sum) break;
    sum = next;
  }
  return sum * exp_negative(-0.5 * z * z) * kInverseSqrt2Pi;
}

// SplitMix64's output function (Steele, Lea, Flood 2014): a bijection whose outputs of a counter pass as
// random.
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t counter) {
  std::uint64_t z = counter * 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

}  // namespace srd::stable
