// SPDX-License-Identifier: Apache-2.0
#include "dsp/pose/systematic_watch.hpp"

#include <algorithm>

namespace srd::dsp {

SystematicWatch::SystematicWatch(const UnsurePose& camera, int width, int height, std::span<const Vec3<double>> points,
                                 const WaterAbove& first, const Vec2<double>& centre)
    : camera_(camera), points_(points.begin(), points.end()), water_(first), centre_(centre) {
  corners_.reserve(points_.size());
  sums_.start(water_.model.modes.size(), 1);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto seen = see_point(camera_.view, points_[i], &water_);
    if (!seen || !(seen->pixel.x() >= 0 && seen->pixel.x() < width && seen->pixel.y() >= 0 && seen->pixel.y() < height))
      continue;
    (void)sums_.add({&camera_, 1}, {0, static_cast<int>(i), 1}, points_[i], water_);
  }
  finish();
}

void SystematicWatch::follow(const Coefficients<float>& surface, std::span<const Observation<float>> corners) {
  if (next_ == corners_.size()) {
    if (!corners_.empty()) finish();
    water_.surface = surface.cast<double>();
    corners_.clear();
    for (const Observation<float>& corner : corners.first(std::min(corners.size(), corners_.capacity())))
      corners_.push_back({0, corner.point, static_cast<double>(corner.sigma)});
    next_ = 0;
    sums_.start(water_.model.modes.size(), 1);
  }
  const std::size_t end = std::min(next_ + kCornersAFrame, corners_.size());
  for (; next_ < end; ++next_) {
    const CountedCorner& corner = corners_[next_];
    (void)sums_.add({&camera_, 1}, corner, points_[static_cast<std::size_t>(corner.point)], water_);
  }
}

// A fit whose corners do not determine the surface leaves the deviation of the one before.
void SystematicWatch::finish() {
  const auto surface = sums_.surface({&camera_, 1}, points_, water_.model);
  if (!surface) return;
  deviation_ = surface->deviation;
  height_deviation_ = surface->deviation_at(water_.model, centre_);
}

}  // namespace srd::dsp
