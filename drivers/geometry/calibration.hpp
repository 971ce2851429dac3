// SPDX-License-Identifier: Apache-2.0
// calibration.yml: a camera's intrinsics, in OpenCV FileStorage keys as OpenSRD writes them: camera_matrix,
// distortion_coefficients (4, 5, 8, 12 or 14), image_width, image_height. Counts, ranges and NaN are checked. Where they are
// known, two further keys that other readers pass over: calibration_covariance, of fx fy cx cy and the coefficients as listed
// (square, 4 more than these), and calibration_date ("2026-11-28").
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "drivers/support/day.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/optics/lens.hpp"
#include "dsp/optics/view.hpp"

namespace srd {

struct Calibration {
  dsp::CameraModel<double> camera;  // the same distortion, filled up with zeros
  std::vector<double> distortion;   // as the file lists it; write_calibration writes this list
  int image_width = 0;              // px; 0: the file says none
  int image_height = 0;
  std::optional<dsp::IntrinsicsMatrix> covariance{};  // zero beyond the listed coefficients; none: not known
  Day date = 0;
};

// kInput naming file and key. A lens of another formula (distortion_model: equidistant, fisheye_model: 1, ..) is refused
// by its name.
[[nodiscard]] Outcome<Calibration> read_calibration(const std::filesystem::path& file);
[[nodiscard]] Outcome<void> write_calibration(const std::filesystem::path& file, const Calibration& calibration);

}  // namespace srd
