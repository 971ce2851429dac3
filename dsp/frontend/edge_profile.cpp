// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/edge_profile.hpp"

#include <algorithm>
#include <cstdlib>

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

// The step edge of a normal distribution of deviation 1, on a grid: the tables ask for it a million times.
class NormalEdge {
 public:
  NormalEdge() {
    for (int i = 0; i <= kCount; ++i) {
      const double t = static_cast<double>(i) / kPerOne, falls = bell(t);
      at_[static_cast<std::size_t>(i)] = {kRootOfTwoOverPi * falls * error_series(t), kRootOfTwoOverPi * falls};
    }
  }
  struct Place {
    double step, slope;
  };
  // Hermite's cubic between the grid's points, within 1e-11.
  [[nodiscard]] Place at(double s) const {
    const double t = (s < 0 ? -s : s) * kPerOne;
    if (t >= kCount) return {s < 0 ? -1.0 : 1.0, 0};
    const auto i = static_cast<std::size_t>(t);
    const double x = t - static_cast<double>(i), y = 1 - x, h = 1.0 / kPerOne;
    const Place a = at_[i], b = at_[i + 1];
    const double step = y * y * (1 + 2 * x) * a.step + x * x * (1 + 2 * y) * b.step + h * x * y * (y * a.slope - x * b.slope);
    return {s < 0 ? -step : step, y * a.slope + x * b.slope};
  }

 private:
  static constexpr int kPerOne = 256, kCount = 8 * kPerOne;
  std::array<Place, kCount + 1> at_{};
};

// The step edge of this deviation, integrated from 0 once and, but for a multiple of x, twice.
struct Integrals {
  double once, twice;
};

Integrals integrals(const NormalEdge& edge, double x, double deviation) {
  const NormalEdge::Place at = edge.at(x / deviation);
  return {x * at.step + deviation * (at.slope - kRootOfTwoOverPi),
          (x * x + deviation * deviation) / 2 * at.step + deviation * x * at.slope / 2};
}

std::int16_t rounded(double x) { return static_cast<std::int16_t>(x < 0 ? x * (1 << 14) - 0.5 : x * (1 << 14) + 0.5); }

constexpr EdgeProfile::Value normal_at(double s) {
  const double size = s < 0 ? -s : s, falls = bell(size);
  const double step = kRootOfTwoOverPi * falls * error_series(size) * (1 << 14) + 0.5;
  return {static_cast<std::int16_t>(s < 0 ? -step : step),
          static_cast<std::int16_t>(kRootOfTwoOverPi * falls * (1 << 14) + 0.5)};
}

// Mean over boxes of these widths of the edge that the normal distribution makes.
EdgeProfile::Value mixed_at(const NormalEdge& edge, double s, double larger, double smaller, double deviation) {
  const auto at = [&](double x) { return integrals(edge, x, deviation); };
  if (smaller == 0) {
    const Integrals right = at(s + larger / 2), left = at(s - larger / 2);
    const auto step_at = [&](double x) { return edge.at(x / deviation).step; };
    return {rounded((right.once - left.once) / larger), rounded((step_at(s + larger / 2) - step_at(s - larger / 2)) / larger)};
  }
  const double outer = (larger + smaller) / 2, inner = (larger - smaller) / 2, area = larger * smaller;
  const Integrals a = at(s + outer), b = at(s + inner), c = at(s - inner), d = at(s - outer);
  return {rounded((a.twice - b.twice - c.twice + d.twice) / area), rounded((a.once - b.once - c.once + d.once) / area)};
}

// A cell holds four numbers of Q10: their mean.
constexpr double middle(int cell) { return (4 * cell + 1.5 - EdgeProfile::kReachQ10) / 1024; }

constexpr EdgeProfile::Table make_normal() {
  EdgeProfile::Table table{};
  for (int i = 0; i < EdgeProfile::kCells; ++i) table[static_cast<std::size_t>(i)] = normal_at(middle(i));
  return table;
}

Tables make_all() {
  const NormalEdge edge;
  Tables tables{};
  for (int shape = 0; shape < EdgeProfile::kShapes; ++shape) {
    EdgeProfile::Table& table = tables[static_cast<std::size_t>(shape)];
    const int sixteenths = shape % EdgeProfile::kParts, thirds = shape / EdgeProfile::kParts;
    const double part = sixteenths / 16.0, ratio = thirds / double{EdgeProfile::kRatios - 1};
    if (part == 0) {
      table = EdgeProfile::table(0);
      continue;
    }
    // Two boxes w and r w have the variance (1 + r^2) w^2 / 12.
    const double larger = root(12 * part / (1 + ratio * ratio)), deviation = root(1 - part);
    for (int i = 0; i < EdgeProfile::kCells; ++i)
      table[static_cast<std::size_t>(i)] = mixed_at(edge, middle(i), larger, ratio * larger, deviation);
  }
  return tables;
}

}  // namespace

alignas(64) constinit const EdgeProfile::Table EdgeProfile::kNormal = make_normal();

const EdgeProfile::Table& EdgeProfile::mixed(int shape) {
  alignas(64) static const Tables kTables = make_all();
  return kTables[static_cast<std::size_t>(shape)];
}

int EdgeProfile::sharp_shape_of(std::int32_t nx_q14, std::int32_t ny_q14, std::int64_t blur_q12) {
  const std::int32_t x = std::abs(nx_q14), y = std::abs(ny_q14);
  const std::int64_t ratio = divide_rounded(std::int64_t{kRatios - 1} * std::min(x, y), std::max({x, y, 1}));
  // The boxes' part of the variance in 1/16: 16 / (12 blur^2).
  const std::int64_t part = divide_rounded(std::int64_t{1} << 26, 3 * blur_q12 * blur_q12);
  return static_cast<int>(ratio) * kParts + static_cast<int>(std::min<std::int64_t>(part, kParts - 1));
}

}  // namespace srd::dsp
