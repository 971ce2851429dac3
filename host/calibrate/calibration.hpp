// SPDX-License-Identifier: Apache-2.0
// From images to a camera with its errors and what is to be said of them.
#pragma once

#include <string>
#include <vector>

#include "host/bundle/model_check.hpp"
#include "host/bundle/projection_uncertainty.hpp"
#include "host/bundle/view_advice.hpp"
#include "host/bundle/zoom_change.hpp"
#include "host/calibrate/options.hpp"

namespace srd::host {

// How the views lie to the camera and in the image.
struct Coverage {
  double image_part = 0;                         // of 10 x 10 fields of the image, those with corners, 0 to 1
  std::vector<char> fields;                      // 100, row by row
  double least_tilt = 0, most_tilt = 0;          // of the board against the image plane, degrees
  double largest_extent = 0;                     // longest side of the largest board against the image's width
  double near_mm = 0, usual_mm = 0, far_mm = 0;  // from the camera to the board's middle
};

struct CalibrationResult {
  bundle::BoardShape board;
  int width = 0, height = 0;          // px
  std::vector<SightedBoard> sighted;  // those that are used, in the order of views
  std::vector<bundle::BoardView> views;
  bundle::CameraFit fit;
  bundle::ModelCheck check;
  std::optional<bundle::ZoomChange> zoom;
  Coverage coverage;
  std::vector<bundle::UncertaintyMap> maps;  // at the board's usual distance, half and twice of it
  bundle::NextView next;
  std::vector<std::string> warnings;  // what a person should know, most serious first
};

// Called with images done and of how many.
using CalibrationProgress = void (*)(std::size_t done, std::size_t of);

// kInput, with advice, when images cannot be used together or do not determine the camera.
[[nodiscard]] Outcome<CalibrationResult> calibrate(const CalibratePlan& plan, CalibrationProgress progress);

// The same from boards that were found already.
[[nodiscard]] Outcome<CalibrationResult> calibrate_boards(const CalibratePlan& plan, std::vector<SightedBoard> sighted,
                                                          std::vector<std::string> warnings);

}  // namespace srd::host
