// SPDX-License-Identifier: Apache-2.0
// Pictures of a pose: the corners over the reference image, and what is left of them on the pattern.
#pragma once

#include "host/plot/scene.hpp"
#include "host/pose/measured_pose.hpp"

namespace srd::host {

// The image with every corner (its place in the list at the outer ones and every fifth), the axes of the world and the
// residuals, magnified so that they can be seen; the scale is written beside.
[[nodiscard]] Scene overlay_picture(const MeasuredPose& pose, const dsp::WaterAbove* water);
// Over the pattern, its longer side to the right: what is left of each corner, mm.
[[nodiscard]] Scene residual_map(const MeasuredPose& pose, const std::vector<dsp::Vec2<double>>& left_mm);

}  // namespace srd::host
