// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/sharp_edge.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "dsp/core/integer_math.hpp"

namespace srd::dsp {

namespace {

// E0 = erf(z / sqrt 2) and its derivative D0 at z = i/32, Q28; beyond 6 it is 1 within 2e-9.
struct NormalStep {
  std::int64_t step, slope;
};
constexpr int kGridBits = 5, kGridReach = 6;
using NormalSteps = std::array<NormalStep, (kGridReach << kGridBits) + 1>;

// From additions, multiplications and divisions alone: all machines and compilers round them alike.
constexpr NormalSteps make_normal_steps() {
  NormalSteps steps{};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double z = static_cast<double>(i) / (1 << kGridBits);
    double power = 1, growth = 1, term = z, sum = z;
    for (int k = 1; power > 1e-12 * growth; ++k) {
      power *= z * z / 2 / k;
      growth += power;
    }
    for (int k = 1; term > 1e-12 * sum; ++k) {
      term *= z * z / (2 * k + 1);
      sum += term;
    }
    const double slope =
        0.7978845608028654 / growth;  // sqrt(2/pi) exp(-z^2/2); its integral is slope (z + z^3/3 + z^5/15 + ..)
    steps[i] = {static_cast<std::int64_t>(slope * sum * (1 << 28) + 0.5), static_cast<std::int64_t>(slope * (1 << 28) + 0.5)};
  }
  return steps;
}

constexpr NormalSteps kNormalSteps = make_normal_steps();

// Hermite's cubic, within 1e-8. z Q16; t is the place between two of the grid.
constexpr int kFraction = 16 - kGridBits;
std::int64_t between(std::int64_t a, std::int64_t by_a, std::int64_t b, std::int64_t by_b, std::int64_t t) {
  constexpr std::int64_t kOne = 1 << kFraction;
  const std::int64_t r = kOne - t;
  // |values| <= 2^28, each weight <= 2^33: the sum stays below 2^62.
  const std::int64_t values = r * r * (kOne + 2 * t) * a + t * t * (kOne + 2 * r) * b;
  return (values + ((t * r * (r * by_a - t * by_b)) >> kGridBits)) >> (3 * kFraction);
}

NormalStep normal_step(std::int64_t z_q16) {
  const std::int64_t size = std::abs(z_q16);
  const auto i = static_cast<std::size_t>(size >> kFraction);
  if (i + 1 >= kNormalSteps.size()) return {z_q16 < 0 ? -(1 << 28) : 1 << 28, 0};
  const std::int64_t t = size & ((1 << kFraction) - 1);
  const NormalStep a = kNormalSteps[i], b = kNormalSteps[i + 1];
  const auto bend = [](std::size_t at, std::int64_t slope) { return -((static_cast<std::int64_t>(at) * slope) >> kGridBits); };
  const std::int64_t step = between(a.step, a.slope, b.step, b.slope, t);
  return {z_q16 < 0 ? -step : step, between(a.slope, bend(i, a.slope), b.slope, bend(i + 1, b.slope), t)};
}

}  // namespace

SharpEdge::SharpEdge(std::int32_t nx_q14, std::int32_t ny_q14, std::int64_t blur_q12, int parts) : blur_(blur_q12) {
  // A narrower box than 1/32 px is a sharp change of slope as good as any.
  constexpr std::int64_t kLeastBox = 1 << (16 - 5);
  // How the lens's blur changes an edge is asked for steps of it, not for infinitely small ones.
  constexpr std::int64_t kLeastLens = (1 << 16) / 10;
  const std::int64_t x = std::int64_t{4} * std::abs(nx_q14), y = std::int64_t{4} * std::abs(ny_q14);
  const std::int64_t wide = std::max(x, y) / parts, narrow = std::max(std::min(x, y), kLeastBox) / parts;
  inner_ = (wide - narrow) / 2;
  outer_ = inner_ + narrow;
  per_area_ = (std::int64_t{1} << 48) / ((outer_ + inner_) * narrow);
  lens_ = isqrt(static_cast<std::uint64_t>(std::max<std::int64_t>(blur_q12 * blur_q12 - (1 << 24) / 12, 1)) << 8);
  per_lens_ = (std::int64_t{1} << 32) / lens_;
  const std::int64_t used = std::max(lens_, kLeastLens);
  per_wide_ = (std::int64_t{1} << 32) / used;
  reach_ = outer_ + kGridReach * used;
}

SharpEdge::Value SharpEdge::at(std::int64_t x_q16) const {
  if (std::abs(x_q16) >= reach_) return {x_q16 < 0 ? -(1 << 14) : 1 << 14, 0, 0};
  // E integrated twice is ((x^2 + s^2) E0 + s x D0) / 2, once x E0 + s D0 and a constant. Q32 and Q28; |x| < 2^19 in Q16.
  std::int64_t twice = 0, once = 0, never = 0;
  const auto take = [&](std::int64_t x, int sign) {
    const NormalStep n = normal_step((x * per_lens_) >> 16);
    twice += sign * ((((x * x + lens_ * lens_) >> 8) * n.step + ((lens_ * x) >> 8) * n.slope) >> 21);
    once += sign * ((x * n.step + lens_ * n.slope) >> 16);
    never += sign * normal_step((x * per_wide_) >> 16).step;
  };
  take(x_q16 + outer_, 1);
  take(x_q16 + inner_, -1);
  take(x_q16 - inner_, -1);
  take(x_q16 - outer_, 1);
  const auto mean = [&](std::int64_t sum, int q) { return (sum * per_area_) >> (16 + q - 14); };
  const std::int64_t slope = mean(once, 28), bend = mean(never, 28);
  return {static_cast<std::int32_t>(std::clamp<std::int64_t>(mean(twice, 32), -(1 << 14), 1 << 14)),
          static_cast<std::int32_t>((slope * blur_) >> 12), static_cast<std::int32_t>((bend * blur_ >> 12) * blur_ >> 12)};
}

}  // namespace srd::dsp
