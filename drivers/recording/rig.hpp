// SPDX-License-Identifier: Apache-2.0
// Files that say where a camera is and what it looks at: calibration.yml, pose.yml, points.txt.
// OpenCV FileStorage keys as OpenSRD writes them. Every reader checks counts, ranges and NaN, and names file
// and key.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"
#include "dsp/optics/view.hpp"

namespace srd {

// camera_matrix, distortion_coefficients (4, 5, 8, 12 or 14), image_width, image_height (0 when the file has
// none). A lens of another formula (distortion_model: equidistant, fisheye_model: 1, ..) is refused by its name. camera holds the same distortion, filled up with zeros; write_calibration writes the list as given.
struct Calibration {
  dsp::CameraModel<double> camera;
  std::vector<double> distortion;
  int image_width = 0;
  int image_height = 0;
};

// Bottom points F, mm, in W.
using Points = std::vector<dsp::Vec3<double>>;

[[nodiscard]] Outcome<Calibration> read_calibration(const std::filesystem::path& file);
[[nodiscard]] Outcome<void> write_calibration(const std::filesystem::path& file, const Calibration& calibration);
// Rotationmatrix (orthonormal to 1e-3, determinant +1; re-orthonormalised), TranslationVector.
[[nodiscard]] Outcome<dsp::Pose<double>> read_pose(const std::filesystem::path& file);
[[nodiscard]] Outcome<void> write_pose(const std::filesystem::path& file, const dsp::Pose<double>& pose);
// x y z a line, white space or commas between; blank lines and '#' comments skipped; at least one point, none
// twice.
[[nodiscard]] Outcome<Points> read_points(const std::filesystem::path& file);
[[nodiscard]] Outcome<void> write_points(const std::filesystem::path& file, const Points& points);

}  // namespace srd
