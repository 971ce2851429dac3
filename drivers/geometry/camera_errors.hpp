// SPDX-License-Identifier: Apache-2.0
// What calibration.yml and pose.yml together say of how sure a camera is, for the systematic deviation of what it measures.
#pragma once

#include <optional>

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/pose.hpp"
#include "dsp/pose/height_of_pose.hpp"

namespace srd {

struct KnownErrors {
  dsp::CameraErrors errors;
  Day pose_date = 0;  // 0: not known
  // Of the calibration whose errors are in it; none: the calibration is taken as exact, since its file or the pose's says
  // nothing of its errors. A date that is not known is 0.
  std::optional<Day> calibration_date{};
};

// Nothing without the pose's errors.
[[nodiscard]] inline std::optional<KnownErrors> known_errors(const Calibration& calibration,
                                                             const std::optional<PoseErrors>& pose) {
  if (!pose) return std::nullopt;
  KnownErrors known;
  known.errors.pose = pose->covariance;
  known.pose_date = pose->date;
  if (!calibration.covariance || !pose->by_calibration) return known;
  known.errors.calibration = *calibration.covariance;
  known.errors.pose_by_calibration = *pose->by_calibration;
  known.calibration_date = calibration.date;
  return known;
}

}  // namespace srd
