// SPDX-License-Identifier: Apache-2.0
#include "host/run/identities.hpp"

namespace srd::host {

namespace {

// Sum of distances between where the corners' rays meet the pattern's plane, water or not, and their points.
double misfit(std::span<const ListedCorner> corners, const RunCamera& camera, const Points& points, bool from_end) {
  const dsp::View<double> view{camera.calibration.camera, camera.pose};
  double sum = 0;
  for (const ListedCorner& corner : corners) {
    const auto& point = points[static_cast<std::size_t>(point_at(camera, corner.place, from_end))];
    const auto ray = view.ray(corner.normalised);
    if (!(ray.direction.z() < 0)) continue;
    const dsp::Vec3<double> hit = ray.origin + (point.z() - ray.origin.z()) / ray.direction.z() * ray.direction;
    sum += (hit - point).norm();
  }
  return sum;
}

}  // namespace

bool counts_from_end(std::span<const ListedCorner> corners, const RunCamera& camera, const Points& points) {
  return misfit(corners, camera, points, true) < 0.5 * misfit(corners, camera, points, false);
}

int point_at(const RunCamera& camera, int place, bool from_end) {
  const int last = static_cast<int>(camera.points.size()) - 1;
  return camera.points[static_cast<std::size_t>(from_end ? last - place : place)];
}

}  // namespace srd::host
