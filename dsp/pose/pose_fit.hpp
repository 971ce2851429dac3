// SPDX-License-Identifier: Apache-2.0
// The pose of a camera from corners whose points are known, dry or through still water, and how sure it is. Optics (26),
// (27). Pure; nothing on the heap.
#pragma once

#include <span>

#include "dsp/optics/lens.hpp"
#include "dsp/pose/seen_point.hpp"

namespace srd::dsp {

// Columns as IntrinsicsMatrix has them.
using PoseByIntrinsics = Eigen::Matrix<double, 6, kMaxIntrinsics>;

struct PoseCorner {
  Vec3<double> point;  // mm, W
  Vec2<double> pixel;  // raw image, px
  double sigma = 1;    // standard deviation per axis, px, > 0
};

struct PoseEstimate {
  Pose<double> pose;
  PoseMatrix cofactor = PoseMatrix::Zero();  // (J'WJ)^-1: the covariance if the corners' deviations are right
  // d pose / d level, where the corners are seen through water: what a wrong level does to the pose.
  PoseChange by_level = PoseChange::Zero();
  // d pose / d intrinsics: what a wrong calibration does to the pose that is found with it. Optics (29a).
  PoseByIntrinsics by_intrinsics = PoseByIntrinsics::Zero();
  double cost = 0;             // sum of |residual / sigma|^2
  double variance_factor = 1;  // cost over (residuals - 6), 1 when sigmas are right; 1 when there are only 3 corners
  int corners = 0;

  // Of a PoseChange, if the calibration is right. Optics (27). level_deviation: mm; 0 where there is no water.
  [[nodiscard]] PoseMatrix covariance(double level_deviation = 0) const {
    return variance_factor * cofactor + level_deviation * level_deviation * (by_level * by_level.transpose());
  }
};

// From a start within some tenths of the distance. kInvalidArgument: fewer than 3 corners or a sigma <= 0; kSingular: the
// corners do not determine the pose; kOutOfDomain: the start sees not all points; kNotConverged.
[[nodiscard]] Result<PoseEstimate> fit_pose_to(const CameraModel<double>& camera, const Pose<double>& start,
                                               std::span<const PoseCorner> corners, const WaterAbove* water);

}  // namespace srd::dsp
