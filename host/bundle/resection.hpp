// SPDX-License-Identifier: Apache-2.0
// The pose of a board that a calibrated camera sees, and how well it agrees.
#pragma once

#include <optional>

#include "host/bundle/camera_solve.hpp"

namespace srd::bundle {

struct Resection {
  PoseVector pose;
  double chi_square = 0;  // of its corners, with the deviations of the calibration
};

// Lens and board as the calibration has them. kNotConverged: the corners give no pose.
[[nodiscard]] Result<Resection> resect(const BoardShape& shape, const BoardView& view, const CameraFit& fit);

// A view of a part of a board: rows and columns moved to where they fit the others best, corners counted from the
// board's own first. Where places fit equally well it does not matter which is taken. odd: whether the move's rows and
// columns together are, as the colours say; nothing: they do not tell. kNotConverged: none gives a pose.
[[nodiscard]] Result<BoardView> place_part(const BoardShape& shape, const BoardView& part, int part_rows, int part_columns,
                                           const CameraFit& fit, std::optional<bool> odd = std::nullopt);

}  // namespace srd::bundle
