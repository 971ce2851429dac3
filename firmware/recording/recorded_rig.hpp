// SPDX-License-Identifier: Apache-2.0
// What goes beside the images of a recording, so that it can be replayed.
#pragma once

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "drivers/recording/recorded_optics.hpp"

namespace srd::firmware {

struct RecordedRig {
  Calibration calibration;
  dsp::Pose<double> pose;
  std::optional<PoseErrors> pose_errors{};
  Points points;
  RecordedOptics optics;
};

}  // namespace srd::firmware
