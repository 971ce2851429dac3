// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/edge_profile.hpp"

#include <algorithm>

#include "dsp/core/integer_math.hpp"

namespace srd::dsp {

namespace {

using Tables = std::array<EdgeProfile::Table, EdgeProfile::kShapes>;

// From additions, multiplications and divisions alone, which every machine and compiler round alike: no libm has a say in it.
constexpr double root(double x) {
  double y = 1;
  for (int i = 0; i < 40; ++i) y = 0.5 * (y + x / y);
  return y;
}

// exp(-s^2/2) as 1 / exp(s^2/2); erf(s/sqrt2) = sqrt(2/pi) exp(-s^2/2) (s + s^3/3 + s^5/15 + ..): all terms are positive.
constexpr double kRootOfTwoOverPi = 0.7978845608028654;

constexpr double bell(double s) {
  double power = 1, e = 1;
  for (int k = 1; power > 1e-9 * e; ++k) {
    power *= s * s / 2 / k;
    e += power;
  }
  return 1 / e;
}

// Without the factor sqrt(2/pi) bell(s), s >= 0.
constexpr double error_series(double s) {
  double term = s, sum = s;
  for (int k = 1; term > 1e-9 * sum; ++k) {
    term *= s * s / (2 * k + 1);
    sum += term;
  }
  return sum;
}

constexpr double step_of_normal(double x, double deviation) {
  const double s = (x < 0 ? -x : x) / deviation;
  const double value = s > 8 ? 1 : kRootOfTwoOverPi * bell(s) * error_series(s);
  return x < 0 ? -value : value;
}

// The integral of step_of_normal from 0.
constexpr double ramp_of_normal(double x, double deviation) {
  const double s = (x < 0 ? -x : x) / deviation;
  const double falls = s > 8 ? 0 : bell(s);
  return (x < 0 ? -x : x) * step_of_normal(x < 0 ? -x : x, deviation) + deviation * kRootOfTwoOverPi * (falls - 1);
}

constexpr EdgeProfile::Value value_at(double s, double box, double normal) {
  double step = 0, slope = 0;
  if (box == 0) {
    step = step_of_normal(s, 1);
    slope = s > 8 || s < -8 ? 0 : kRootOfTwoOverPi * bell(s);
  } else if (normal == 0) {
    step = std::clamp(2 * s / box, -1.0, 1.0);
    slope = s < box / 2 && s > -box / 2 ? 2 / box : 0;
  } else {
    step = (ramp_of_normal(s + box / 2, normal) - ramp_of_normal(s - box / 2, normal)) / box;
    slope = (step_of_normal(s + box / 2, normal) - step_of_normal(s - box / 2, normal)) / box;
  }
  const auto rounded = [](double x) { return static_cast<std::int16_t>(x < 0 ? x * (1 << 14) - 0.5 : x * (1 << 14) + 0.5); };
  return {rounded(step), rounded(slope)};
}

constexpr EdgeProfile::Table make(int shape) {
  const double part = shape / double{EdgeProfile::kShapes - 1};
  const double box = shape == 0 ? 0 : root(12 * part), normal = part < 1 ? root(1 - part) : 0;
  EdgeProfile::Table table{};
  for (int i = 0; i < EdgeProfile::kCells; ++i)  // a cell holds four numbers of Q10: their mean
    table[static_cast<std::size_t>(i)] = value_at((4 * i + 1.5 - EdgeProfile::kReachQ10) / 1024, box, normal);
  return table;
}

Tables make_all() {
  Tables tables{};
  for (int shape = 0; shape < EdgeProfile::kShapes; ++shape) tables[static_cast<std::size_t>(shape)] = make(shape);
  return tables;
}

}  // namespace

alignas(64) constinit const EdgeProfile::Table EdgeProfile::kNormal = make(0);

const EdgeProfile::Table& EdgeProfile::mixed(int shape) {
  alignas(64) static const Tables kTables = make_all();
  return kTables[static_cast<std::size_t>(shape)];
}

int EdgeProfile::sharp_shape_of(std::int32_t nx_q14, std::int32_t ny_q14, std::int64_t blur_q12) {
  const std::int64_t product_q14 = (static_cast<std::int64_t>(nx_q14) * ny_q14) >> 14;
  const std::int64_t fourth_q28 = (std::int64_t{1} << 28) - 2 * product_q14 * product_q14;  // nx^4 + ny^4
  const std::int64_t fourth_root_q14 = isqrt(static_cast<std::uint64_t>(std::max<std::int64_t>(fourth_q28, 0)));
  // Part of the variance in 1/16: 16 sqrt(nx^4 + ny^4) / (12 blur^2).
  const std::int64_t variance_q24 = blur_q12 * blur_q12;
  const std::int64_t part = divide_rounded(fourth_root_q14 << 12, 3 * variance_q24);
  return static_cast<int>(std::min<std::int64_t>(part, kShapes - 1));
}

}  // namespace srd::dsp
