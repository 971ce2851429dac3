// SPDX-License-Identifier: Apache-2.0
#include "dsp/pose/pose_check.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "dsp/pose/pose_comparison.hpp"

namespace srd::dsp {

namespace {

constexpr double kLeastDepth = 1;    // mm of water over the plates
constexpr double kLevelStep = 0.05;  // mm: differences of the cost round its least
constexpr int kLevelTrials = 40;     // of a search that ends within 0.62^40 of its range
// Water counts where it explains so many deviations of what air leaves: 1 in 10^7 by chance.
constexpr double kWetStatistic = 28;

WaterAbove still_water(const Media<double>& media, double level) {
  WaterAbove water{{ModeList::standard(1).value(), 1, 1, 0, 0}, Coefficients<double>(1), media};
  water.surface[0] = level;
  return water;
}

// Golden section: the cost over the level has one least where the corners tell the level at all.
template <class Cost>
double least_of(double low, double high, Cost&& cost) {
  constexpr double kGolden = 0.6180339887498949;
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double at_a = cost(a), at_b = cost(b);
  for (int trial = 0; trial < kLevelTrials && high - low > 1e-4; ++trial) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      at_a = cost(a = high - kGolden * (high - low));
    } else {
      low = a;
      a = b;
      at_a = at_b;
      at_b = cost(b = low + kGolden * (high - low));
    }
  }
  return at_a < at_b ? a : b;
}

// x' C^-1 x / 6
Result<double> statistic_of(const PoseChange& change, const PoseMatrix& covariance) {
  const PoseChange root = covariance.diagonal().cwiseSqrt();
  if (!(root.minCoeff() > 0)) return Errc::kSingular;
  const PoseChange per = root.cwiseInverse(), scaled = per.cwiseProduct(change);
  const Eigen::LDLT<PoseMatrix> factors(PoseMatrix(per.asDiagonal() * covariance * per.asDiagonal()));
  return scaled.dot(factors.solve(scaled)) / 6;
}

}  // namespace

double by_chance_between(const PoseCheck& a, const PoseCheck& b) {
  const auto statistic = statistic_of(change_between(a.found.pose, b.found.pose), a.found_covariance + b.found_covariance);
  const double freedom = 2.0 * (a.found.corners + b.found.corners) - 14;
  return statistic ? f_survival(*statistic, 6, freedom) : 1;
}

Result<PoseCheck> check_pose(const PoseCheckRequest& request, std::span<const PoseCorner> corners) {
  if (corners.size() < 8) return Errc::kInvalidArgument;
  const auto fit = [&](const WaterAbove* water) { return fit_pose_to(request.camera, request.stated, corners, water); };
  // Dry, plates lie in air: water of air's index over them.
  Media<double> dry_media = request.media;
  dry_media.water = dry_media.air;
  const WaterAbove air = still_water(dry_media, request.media.plates() + kLeastDepth);
  const WaterAbove* const above_dry = request.media.n_layers > 0 ? &air : nullptr;
  const auto dry = fit(above_dry);

  const double lowest = request.media.plates() + kLeastDepth;
  const double highest = std::min(request.highest_mm, 0.8 * request.stated.centre().z());
  const auto cost_at = [&](double level) {
    const WaterAbove water = still_water(request.media, level);
    const auto found = fit(&water);
    return found ? found->cost : HUGE_VAL;
  };
  PoseCheck check;
  double level = lowest;
  Result<PoseEstimate> wet = Errc::kOutOfDomain;
  if (highest > lowest + 2 * kLevelStep) {
    level = least_of(lowest, highest, cost_at);
    const WaterAbove water = still_water(request.media, level);
    wet = fit(&water);
  }
  if (!dry && !wet) return dry.error();
  const double freedom = 2 * static_cast<double>(corners.size()) - 7;
  check.wet = wet.ok() && (!dry || (dry->cost - wet->cost) * freedom > kWetStatistic * wet->cost);
  check.found = check.wet ? *wet : *dry;
  check.variance_factor = check.wet ? check.found.cost / freedom : check.found.variance_factor;
  PoseMatrix own = check.found.cofactor;
  const WaterAbove water = still_water(request.media, level);
  if (check.wet) {
    // The cost is (h - level)^2 / variance near its least.
    check.level_mm = level;
    const double curvature =
        (cost_at(level + kLevelStep) + cost_at(level - kLevelStep) - 2 * check.found.cost) / (kLevelStep * kLevelStep);
    if (!(curvature > 0) || !std::isfinite(curvature)) return Errc::kSingular;
    own += 2 / curvature * (check.found.by_level * check.found.by_level.transpose());
    check.level_deviation_mm = std::sqrt(2 / curvature * check.variance_factor);
  }
  check.change = change_between(request.stated, check.found.pose);
  check.found_covariance = check.variance_factor * own;
  check.covariance = check.found_covariance + request.stated_covariance;
  const auto statistic = statistic_of(check.change, check.covariance);
  if (!statistic) return statistic.error();
  check.statistic = *statistic;
  check.by_chance = f_survival(check.statistic, 6, check.wet ? freedom : freedom + 1);
  const View<double> then{request.camera, request.stated}, now{request.camera, check.found.pose};
  for (const PoseCorner& corner : corners) {
    const WaterAbove* const above = check.wet ? &water : above_dry;
    const auto before = see_point(then, corner.point, above), after = see_point(now, corner.point, above);
    if (!before || !after) return Errc::kOutOfDomain;
    check.largest_move_px = std::max(check.largest_move_px, (after->pixel - before->pixel).norm());
  }
  return check;
}

}  // namespace srd::dsp
