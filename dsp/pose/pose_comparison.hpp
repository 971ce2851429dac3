// SPDX-License-Identifier: Apache-2.0
// Has the camera moved against the pattern between two images of it? Optics (28). Pure; nothing on the heap.
#pragma once

#include <span>

#include "dsp/pose/pose_fit.hpp"

namespace srd::dsp {

// One corner in both images.
struct CornerPair {
  Vec3<double> point;
  Vec2<double> before, after;                // raw images, px
  double sigma_before = 1, sigma_after = 1;  // px, > 0
};

// Water over the pattern in one of the images; null: dry.
struct PairedWater {
  const WaterAbove* water = nullptr;
  double level_deviation = 0;  // mm
};

struct PoseComparison {
  Pose<double> before, after;
  PoseChange change = PoseChange::Zero();
  PoseMatrix covariance = PoseMatrix::Zero();  // of the change
  double variance_factor = 1;                  // of what the change leaves of the corners' moves, in their deviations
  double statistic = 0;                        // change' covariance^-1 change / 6
  // How often an unmoved rig would show as large a statistic: F of 6 and 2 n - 6 degrees of freedom.
  double by_chance = 1;
  double largest_move_px = 0;  // of a corner, as far as the change of pose explains it
};

// start: of the pose before. The errors that both images share (the print's, the lens's) cancel: what the first image's
// corners leave of their pose is expected in the second too. Errors as fit_pose_to; kInvalidArgument: fewer than 4 pairs.
[[nodiscard]] Result<PoseComparison> compare_poses(const CameraModel<double>& camera, const Pose<double>& start,
                                                   std::span<const CornerPair> pairs, const PairedWater& before,
                                                   const PairedWater& after, std::span<PoseCorner> workspace);

// Probability that F of these degrees of freedom is at least f. Both > 0; relative error below 1e-9.
[[nodiscard]] double f_survival(double f, double numerator_freedom, double denominator_freedom);

}  // namespace srd::dsp
