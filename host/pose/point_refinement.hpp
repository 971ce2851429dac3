// SPDX-License-Identifier: Apache-2.0
// The pattern's own points from several poses: a print is rarely truer than 0.1 mm, and every corner is seen to a few
// thousandths of that.
#pragma once

#include <filesystem>
#include <vector>

#include "host/pose/measured_pose.hpp"

namespace srd::host {

struct PointRefinement {
  Points points;                             // in the order of the pattern's list
  std::vector<dsp::Vec3<double>> deviation;  // of each, mm, with the poses given
  int views = 0;                             // the reference included
  double before_px = 0, after_px = 0;        // what all views leave, rms an axis, of the list's points and of these
  double print_mm = 0, print_z_mm = 0;       // how far these lie from the list, rms along X and Y, and along Z
  // Sum of squares in their deviations over residuals less what was fitted: 1 when the lens and the corners are right.
  double variance_factor = 0;
};

// The reference and further dry views of the same pattern, from other places, with the same lens. expected_mm: how far a
// point may lie from the list, one standard deviation; it holds what the views do not tell, and the frame and scale as a
// whole. kUsage: fewer than 2 further views. kInput: a view without the board.
[[nodiscard]] Outcome<PointRefinement> refine_points(const MeasuredPose& reference,
                                                     const std::vector<std::filesystem::path>& views,
                                                     const PoseRequest& request, double expected_mm);

}  // namespace srd::host
