// SPDX-License-Identifier: Apache-2.0
// Corners of rendered boards against the truth, while one condition at a time changes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd::study {

struct CornerConditions {
  double blur_px = 0.9;   // sigma of the lens
  double noise = 2;       // sigma, grey levels
  double contrast = 200;  // bright - dark, grey levels
  double square_px = 38;
};

// Deviations are rms per axis, px.
struct CornerRow {
  std::string varied;  // "blur_px", "noise", "contrast", "square_px"
  CornerConditions conditions;
  int corners = 0, found = 0;
  double rms_px = 0;     // found against true
  double stated_px = 0;  // as the corners say themselves
  double bound_px = 0;   // (20)
  double opencv_px = 0;  // cv::cornerSubPix at the half window that is best for these very corners
  int opencv_window = 0;
  [[nodiscard]] double value() const;  // of the condition that is varied
};

using Progress = std::function<void(int done, int all)>;

// quick: fewer conditions and one board each.
[[nodiscard]] Outcome<std::vector<CornerRow>> study_corners(bool quick, const Progress& progress);

}  // namespace srd::study
