// SPDX-License-Identifier: Apache-2.0
// The pattern's corners from one reference image, or the mean of many that nothing has moved between.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/recording/image_file.hpp"
#include "host/run/pose_estimation.hpp"

namespace srd::host {

struct ReferenceView {
  std::vector<BoardCorner> corners;  // as seen: the top left first, along u, then the next row; the mean of the images
  PatternSize seen;                  // rows and columns as they lie in the image
  GrayImage image;                   // the first
  // From image to image, over what the corners' deviations say; 1 when those are right and nothing moved. One image: 0.
  double scatter_factor = 0;
  std::vector<std::string> warnings;
};

// Folders stand for all their images. The board may lie with its rows along u. kInput for no image, one of
// another size than the calibration, one without the whole board, and images that something has moved between.
[[nodiscard]] Outcome<ReferenceView> read_reference(const std::vector<std::filesystem::path>& images,
                                                    const Calibration& calibration, PatternSize board,
                                                    const CornerSearch& search);

}  // namespace srd::host
