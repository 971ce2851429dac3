// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator/checkerboard.hpp"

#include <cmath>
#include <cstddef>

#include "drivers/camera/simulator/stable_math.hpp"

namespace srd {

namespace {

constexpr int kSteps = 128;  // a unit of z; linear interpolation then errs by < 4e-6

// Integral over r = 0..rho of the bivariate normal density at (x, y): by Plackett (1954), what correlation
// adds to P(X > x, Y > y). r = sin(angle) takes the root out of the denominator; Gauss-Legendre, 5 points.
double correlation_gain(double x, double y, double rho) {
  constexpr std::array<double, 5> kNode{-0.90617984593866399, -0.53846931010568309, 0, 0.53846931010568309,
                                        0.90617984593866399};
  constexpr std::array<double, 5> kWeight{0.23692688505618909, 0.47862867049936647, 0.56888888888888889, 0.47862867049936647,
                                          0.23692688505618909};
  // asin by its series: |rho| <= 0.7 (1e-6 there).
  double term = rho, angle = rho;
  for (int n = 1; n < 16; ++n) {
    term *= rho * rho * (2 * n - 1) / (2 * n);
    angle += term / (2 * n + 1);
  }
  double sum = 0;
  for (std::size_t i = 0; i < kNode.size(); ++i) {
    const double a = 0.5 * angle * (kNode[i] + 1), a2 = a * a;
    // sin by its series: |a| < 0.8, error < 1e-9.
    const double s = a * (1 - a2 / 6 * (1 - a2 / 20 * (1 - a2 / 42 * (1 - a2 / 72))));
    sum += kWeight[i] * stable::exp_negative(-(x * x + y * y - 2 * x * y * s) / (2 * (1 - s * s)));
  }
  constexpr double kInverse2Pi = 0.15915494309189533577;
  return 0.5 * angle * sum * kInverse2Pi;
}

}  // namespace

FilteredCheckerboard::FilteredCheckerboard(int rows, int columns, int border_squares, bool origin_dark, double margin)
    : last_x_(rows - 1 + border_squares),
      last_y_(columns - 1 + border_squares),
      first_(-border_squares),
      margin_(static_cast<float>(margin)),
      sign_(origin_dark ? -0.5F : 0.5F) {
  const int count = static_cast<int>(kFarthest) * kSteps + 2;
  for (int i = 0; i < count; ++i)
    erf_.push_back(static_cast<float>(2 * stable::normal_cdf_half(static_cast<double>(i) / kSteps)));
}

FilteredCheckerboard::Edge FilteredCheckerboard::edge(int n, float z, int first, int last) const {
  const float after_sign = (n & 1) == 0 ? 1.0F : -1.0F;
  const float before = n == first ? 0.0F : -after_sign, after = n == last ? 0.0F : after_sign;
  const float before_inside = n == first ? 0.0F : 1.0F, after_inside = n == last ? 0.0F : 1.0F;
  if (z >= kFarthest) return {after, after_inside, 0, 0};
  if (z <= -kFarthest) return {before, before_inside, 0, 0};
  const float position = (z < 0 ? -z : z) * kSteps;
  const auto i = static_cast<std::size_t>(position);
  const float e = erf_[i] + (position - static_cast<float>(i)) * (erf_[i + 1] - erf_[i]);
  const float up = 0.5F + (z < 0 ? -0.5F : 0.5F) * e;
  return {before + (after - before) * up, before_inside + (after_inside - before_inside) * up, after - before,
          after_inside - before_inside};
}

float FilteredCheckerboard::near_edge(int nx, int ny, float zx, float zy, float rho) const {
  const Edge a = edge(nx, zx, first_, last_x_), b = edge(ny, zy, first_, last_y_);
  float wave = a.wave * b.wave, inside = a.inside * b.inside;
  if (a.wave_jump != 0 && b.wave_jump != 0) {
    const auto gain =
        static_cast<float>(correlation_gain(static_cast<double>(zx), static_cast<double>(zy), static_cast<double>(rho)));
    wave += a.wave_jump * b.wave_jump * gain;
    inside += a.inside_jump * b.inside_jump * gain;
  }
  return margin_ + (0.5F - margin_) * inside + sign_ * wave;
}

}  // namespace srd
