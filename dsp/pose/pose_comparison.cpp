// SPDX-License-Identifier: Apache-2.0
#include "dsp/pose/pose_comparison.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace srd::dsp {

namespace {

// Continued fraction of the incomplete beta function, by Lentz's method (Abramowitz and Stegun 26.5.8).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  const auto away = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1, d = 1 / away(1 - (a + b) * x / (a + 1)), h = d;
  for (int m = 1; m < 1000; ++m) {
    for (const bool even : {true, false}) {
      const double term = even ? m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
                               : -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
      d = 1 / away(1 + term * d);
      c = away(1 + term / c);
      h *= d * c;
    }
    if (std::abs(d * c - 1) < 1e-14) break;
  }
  return h;
}

// Regularised incomplete beta function I_x(a, b).
double incomplete_beta(double a, double b, double x) {
  if (!(x > 0)) return 0;
  if (!(x < 1)) return 1;
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

}  // namespace

double f_survival(double f, double numerator_freedom, double denominator_freedom) {
  if (!(f > 0)) return 1;
  return incomplete_beta(denominator_freedom / 2, numerator_freedom / 2,
                         denominator_freedom / (denominator_freedom + numerator_freedom * f));
}

Result<PoseComparison> compare_poses(const CameraModel<double>& camera, const Pose<double>& start,
                                     std::span<const CornerPair> pairs, const PairedWater& before, const PairedWater& after,
                                     std::span<PoseCorner> workspace) {
  if (pairs.size() < 4) return Errc::kInvalidArgument;
  if (workspace.size() < pairs.size()) return Errc::kTooSmall;
  const std::span<PoseCorner> corners = workspace.first(pairs.size());
  // Both images with the same weights, so that what one leaves is not noise to the other's pose.
  for (std::size_t i = 0; i < pairs.size(); ++i)
    corners[i] = {pairs[i].point, pairs[i].before, std::hypot(pairs[i].sigma_before, pairs[i].sigma_after)};
  const auto first = fit_pose_to(camera, start, corners, before.water);
  if (!first) return first.error();
  const View<double> old_view{camera, first->pose};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto seen = see_point(old_view, pairs[i].point, before.water);
    if (!seen) return seen.error();
    corners[i].pixel = pairs[i].after - (pairs[i].before - seen->pixel);
  }
  const auto second = fit_pose_to(camera, first->pose, corners, after.water);
  if (!second) return second.error();

  PoseComparison out;
  out.before = first->pose;
  out.after = second->pose;
  out.change = change_between(first->pose, second->pose);
  out.variance_factor = second->variance_factor;
  out.covariance = second->covariance(after.level_deviation) +
                   before.level_deviation * before.level_deviation * (first->by_level * first->by_level.transpose());
  const PoseChange root = out.covariance.diagonal().cwiseSqrt();
  if (root.minCoeff() > 0) {
    const PoseChange per = root.cwiseInverse(), scaled = per.cwiseProduct(out.change);
    const Eigen::LDLT<PoseMatrix> factors(PoseMatrix(per.asDiagonal() * out.covariance * per.asDiagonal()));
    out.statistic = scaled.dot(factors.solve(scaled)) / 6;
  }
  out.by_chance = f_survival(out.statistic, 6, 2.0 * static_cast<double>(pairs.size()) - 6);
  const View<double> new_view{camera, second->pose};
  for (const CornerPair& pair : pairs) {
    const auto then = see_point(old_view, pair.point, after.water), now = see_point(new_view, pair.point, after.water);
    if (!then || !now) return Errc::kOutOfDomain;
    out.largest_move_px = std::max(out.largest_move_px, (now->pixel - then->pixel).norm());
  }
  return out;
}

}  // namespace srd::dsp
