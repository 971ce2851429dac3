// SPDX-License-Identifier: Apache-2.0
// All inner corners of a checkerboard in one image.
#pragma once

#include <string>
#include <vector>

#include "drivers/support/problem.hpp"
#include "dsp/core/image_view.hpp"
#include "dsp/core/linear_algebra.hpp"
#include "host/run/pattern_size.hpp"

namespace srd::host {

// Of optics (22), as OpenSRD's settings name them.
struct CornerSearch {
  int radius = 5;            // px, 5 or 10
  int threshold = 350;       // least response
  double min_distance = 15;  // px
};

struct BoardCorner {
  dsp::Vec2<double> pixel;          // raw
  bool bright_below_right = false;  // the square between the directions +u and +v
  double sigma_px = 1;              // standard deviation per axis, as the detector states it
};

// The top left of the image first, along u, then the next row. kInput when the board is not there whole:
// says how many corners were found.
[[nodiscard]] Outcome<std::vector<BoardCorner>> find_board_corners(const GrayView& image, PatternSize board,
                                                                   const CornerSearch& search, const std::string& where);

}  // namespace srd::host
