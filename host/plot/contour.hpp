// SPDX-License-Identifier: Apache-2.0
// Lines of equal height on an even grid.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/plot/scene.hpp"

namespace srd::host {

// Polylines where the grid's bilinear surface equals level; places in grid units (x: column, y: row).
// A closed line ends where it starts. Marching squares; a saddle is decided by the cell's mean.
[[nodiscard]] std::vector<std::vector<Place>> contour_lines(const Eigen::MatrixXd& heights, double level);

}  // namespace srd::host
