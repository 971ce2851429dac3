// SPDX-License-Identifier: Apache-2.0
// Which further view of the board would tell most about the camera.
#pragma once

#include <string>

#include "host/bundle/camera_solve.hpp"

namespace srd::bundle {

struct NextView {
  PoseVector pose;
  std::string place;     // "at the upper left of the image"
  std::string attitude;  // "its right edge 35 degrees further away"
  double gain = 0;       // deviations of the camera's parameters shrink by this part on average, 0 to 1
};

// Of square-on and tilted boards in nine places, as large as the views so far, whole in the image: the one that makes
// the volume of the parameters' errors least.
[[nodiscard]] NextView next_view(const BoardShape& shape, const std::vector<BoardView>& views, const CameraFit& fit,
                                 int image_width, int image_height);

}  // namespace srd::bundle
