// SPDX-License-Identifier: Apache-2.0
#include "host/pose/height_effect.hpp"

#include <algorithm>

#include "drivers/geometry/camera_errors.hpp"
#include "drivers/support/text_file.hpp"

namespace srd::host {

namespace {

double extent_along(const Points& points, int axis) {
  const auto [least, most] =
      std::minmax_element(points.begin(), points.end(), [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; });
  return (*most)[axis] - (*least)[axis];
}

}  // namespace

Outcome<std::vector<HeightEffect>> height_effects(const MeasuredPose& pose, const dsp::Media<double>& media,
                                                  const HeightRequest& request) {
  std::vector<HeightEffect> effects;
  std::vector<dsp::CountedCorner> corners;
  for (std::size_t i = 0; i < pose.points.size(); ++i) corners.push_back({0, static_cast<int>(i), 1});
  const dsp::UnsurePose camera{{pose.calibration.camera, pose.fit.pose}, known_errors(pose.calibration, pose.errors())->errors};
  for (const double depth : request.depths_mm) {
    HeightEffect effect;
    effect.depth_mm = depth;
    effect.model.modes = request.modes;
    effect.model.lx = request.lx_mm.value_or(extent_along(pose.points, 0));
    effect.model.ly = request.ly_mm.value_or(extent_along(pose.points, 1));
    dsp::WaterAbove water{effect.model, dsp::Coefficients<double>::Zero(request.modes.size()), media};
    const int level = request.modes.index_of(dsp::Mode{});
    if (level >= 0) water.surface[level] = depth;
    const auto surface = dsp::surface_of_poses({&camera, 1}, pose.points, water, corners);
    if (!surface)
      return Problem{Exit::kInput,
                     "the pattern does not determine a surface at --depth " + number_text(depth),
                     "srd pose",
                     "a depth above the plates and below the camera, and modes that the view tells apart, A00 among them",
                     to_string(surface.error()),
                     "fewer --modes, or another --depth"};
    effect.surface = *surface;
    effects.push_back(std::move(effect));
  }
  return effects;
}

}  // namespace srd::host
