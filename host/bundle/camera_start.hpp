// SPDX-License-Identifier: Apache-2.0
// Where the adjustment of a camera starts: focal length from the views' homographies, poses from these.
#pragma once

#include "host/bundle/camera_solve.hpp"

namespace srd::bundle {

struct CameraStart {
  std::vector<double> intrinsics;
  std::vector<PoseVector> poses;
};

// No distortion, the principal point in the image's middle. kInput: a view whose corners give no pose.
[[nodiscard]] Outcome<CameraStart> start_camera(const BoardShape& shape, const std::vector<BoardView>& views, int image_width,
                                                int image_height, int coefficients);

}  // namespace srd::bundle
