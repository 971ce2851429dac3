// SPDX-License-Identifier: Apache-2.0
#include "firmware/stills/board_sight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace srd::firmware {

namespace {

constexpr int kMostCorners = 4096;
constexpr double kUnitQ12 = 4096;
constexpr std::array kThresholds{200, 100, 50};  // of srd calibrate
constexpr int kMinGap = 8;                       // px between two corners; the finder halves it where squares are smaller
constexpr double kReach = 1.0 / 3;               // of the gap between two corners
constexpr double kMinMatched = 0.9;

// That so many tenths of the values do not exceed.
double tenths(int n, std::vector<double>& values) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(values.size() * static_cast<std::size_t>(n) / 10);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}
double median(std::vector<double>& values) { return tenths(5, values); }

double squared_distance(const SightedCorner& a, const SightedCorner& b) {
  return (a.u - b.u) * (a.u - b.u) + (a.v - b.v) * (a.v - b.v);
}

// The one nearest to a place, other than the one at except.
const SightedCorner* nearest(const std::vector<SightedCorner>& corners, const SightedCorner& place,
                             const SightedCorner* except = nullptr) {
  const SightedCorner* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const SightedCorner& corner : corners) {
    if (&corner == except) continue;
    if (const double d = squared_distance(corner, place); d < least) {
      least = d;
      best = &corner;
    }
  }
  return best;
}

}  // namespace

BoardSighter::BoardSighter(int width, int height) : finder_(width, height, kMostCorners) {}

std::optional<BoardSight> BoardSighter::look_at(const GrayView& image) {
  for (const int threshold : kThresholds) {
    dsp::DetectorOptions options;
    options.threshold = threshold;
    options.min_distance = kMinGap;
    const auto grid = finder_.find(image, options);
    if (!grid || std::min(grid->rows, grid->columns) < kMinSide || grid->found < kMinSide * kMinSide) continue;
    BoardSight sight;
    sight.rows = grid->rows;
    sight.columns = grid->columns;
    std::vector<double> blurs, gaps;
    for (const int cell : grid->cells) {
      if (cell < 0) continue;
      const dsp::CornerFit& fit = finder_.corners()[static_cast<std::size_t>(cell)];
      sight.corners.push_back({fit.corner.u.to<double>(), fit.corner.v.to<double>(), fit.corner.sigma_q12 / kUnitQ12});
      blurs.push_back(fit.shape.blur_q12 / kUnitQ12);
    }
    for (const SightedCorner& corner : sight.corners)
      gaps.push_back(std::sqrt(squared_distance(corner, *nearest(sight.corners, corner, &corner))));
    sight.blur_px = median(blurs);
    sight.gap_px = median(gaps);
    return sight;
  }
  return std::nullopt;
}

std::optional<double> shift_px(const BoardSight& before, const BoardSight& now) {
  const double reach = kReach * now.gap_px;
  std::vector<double> distances, noise;
  for (const SightedCorner& corner : now.corners) {
    const SightedCorner* same = nearest(before.corners, corner);
    if (same == nullptr) return std::nullopt;
    const double d = squared_distance(*same, corner);
    if (d > reach * reach) continue;
    distances.push_back(d);
    noise.push_back(2 * (same->sigma * same->sigma + corner.sigma * corner.sigma));
  }
  const std::size_t most = std::max(before.corners.size(), now.corners.size());
  if (static_cast<double>(distances.size()) < kMinMatched * static_cast<double>(most)) return std::nullopt;
  // The squared length of two normal deviates of one variance has nine tenths of its probability below ln 10 of its mean.
  return std::sqrt(std::max(0.0, tenths(9, distances) - std::log(10.0) * median(noise)));
}

}  // namespace srd::firmware
