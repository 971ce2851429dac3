// SPDX-License-Identifier: Apache-2.0
// What a pose's errors mean for surfaces that are measured with it.
#pragma once

#include <string>
#include <vector>

#include "host/pose/measured_pose.hpp"

namespace srd::host {

struct HeightEffect {
  double depth_mm = 0;  // of the still water that it is computed at
  dsp::SurfaceModel<double> model;
  dsp::SystematicSurface surface;
};

struct HeightRequest {
  std::vector<double> depths_mm;  // above Z = 0
  dsp::ModeList modes;
  std::optional<double> lx_mm, ly_mm;  // not given: the pattern's extent
};

// One a depth; all corners of the pattern, equally weighted. kInput: a depth at which the pattern cannot be seen or does not
// determine the modes.
[[nodiscard]] Outcome<std::vector<HeightEffect>> height_effects(const MeasuredPose& pose, const dsp::Media<double>& media,
                                                                const HeightRequest& request);

}  // namespace srd::host
