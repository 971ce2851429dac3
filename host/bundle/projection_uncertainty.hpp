// SPDX-License-Identifier: Apache-2.0
// How well a calibration says where things are in the image: what errors of lens, poses and board leave together, after
// the freedom that a later pose has is taken out. Optics (32); the method of mrcal, D. Kogan (mean over the boards).
#pragma once

#include <vector>

#include "host/bundle/camera_solve.hpp"

namespace srd::bundle {

struct UncertaintyMap {
  double distance_mm = 0;  // from the camera's centre along the ray
  int columns = 0, rows = 0;
  std::vector<double> worst_px;  // row by row: deviation along the worst direction; NaN where the lens has no ray
  [[nodiscard]] double u(int column, int width) const { return (width - 1.0) * column / (columns - 1); }
  [[nodiscard]] double v(int row, int height) const { return (height - 1.0) * row / (rows - 1); }
  [[nodiscard]] double at(int row, int column) const { return worst_px[static_cast<std::size_t>(row * columns + column)]; }
};

// Deviation at one pixel (u, v), px; NaN where the distortion has no inverse.
[[nodiscard]] double projection_uncertainty(const CameraFit& fit, double u, double v, double distance_mm);
// An even grid from the image's first pixel to its last.
[[nodiscard]] UncertaintyMap uncertainty_map(const CameraFit& fit, int width, int height, double distance_mm, int columns,
                                             int rows);

}  // namespace srd::bundle
