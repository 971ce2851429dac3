// SPDX-License-Identifier: Apache-2.0
// Does a camera still stand where its pose says? The corners of one image, dry or through still water of a level that nobody
// has measured, against a pose and its covariance. Optics (28a). Pure; nothing on the heap.
#pragma once

#include <span>

#include "dsp/pose/pose_fit.hpp"

namespace srd::dsp {

struct PoseCheck {
  bool wet = false;                                  // the corners are seen through water, by what fits them better
  double level_mm = 0, level_deviation_mm = 0;       // of that water
  PoseEstimate found;                                // the pose now
  PoseChange change = PoseChange::Zero();            // from the stated pose to the one now
  PoseMatrix covariance = PoseMatrix::Zero();        // of the change
  PoseMatrix found_covariance = PoseMatrix::Zero();  // the found pose's part of it
  double variance_factor = 1;                        // of what the pose now leaves of the corners, in their deviations
  double statistic = 0;                              // change' covariance^-1 change / 6
  double by_chance = 1;                              // how often an unmoved rig shows as large a statistic, see f_survival
  double largest_move_px = 0;                        // of a corner, from the stated pose to the one now
};

struct PoseCheckRequest {
  CameraModel<double> camera;
  Pose<double> stated;
  PoseMatrix stated_covariance = PoseMatrix::Zero();
  Media<double> media;      // plates lie on the pattern with and without water
  double highest_mm = 500;  // levels are looked for up to here
};

// How often two looks at one rig differ as much; 2 n - 7 degrees of freedom from each. Water that moves between them differs
// far more.
[[nodiscard]] double by_chance_between(const PoseCheck& a, const PoseCheck& b);

// Errors as fit_pose_to; kInvalidArgument: fewer than 8 corners.
[[nodiscard]] Result<PoseCheck> check_pose(const PoseCheckRequest& request, std::span<const PoseCorner> corners);

}  // namespace srd::dsp
