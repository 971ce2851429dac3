// SPDX-License-Identifier: Apache-2.0
// One surface described by several boards: how the coefficients of the common description appear in a board's own, whose
// modes, lengths, origin and place may be others. Pure arithmetic; any thread.
#pragma once

#include <Eigen/Core>

#include "drivers/support/problem.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd::host {

// Where a board's frame W lies in the common one: X = x + cos(turn) Xb - sin(turn) Yb, Y = y + sin(turn) Xb + cos(turn) Yb,
// Z = z + Zb.
struct BoardPlacement {
  double x_mm = 0, y_mm = 0, z_mm = 0;
  double turn_rad = 0;
  [[nodiscard]] dsp::Vec2<double> to_common(const dsp::Vec2<double>& board) const;
  friend bool operator==(const BoardPlacement&, const BoardPlacement&) = default;
};

// A rectangle of the board's frame in which it measures, mm.
struct BoardArea {
  double x_mm = 0, y_mm = 0;           // centre
  double width_mm = 0, height_mm = 0;  // along X and Y, > 0
};

// The board's coefficients that a common surface a gives: ab = map a + constant. Optics (40).
//
// Exact where the board's modes can describe every common one. Where they cannot, the board's fit takes the rest for
// something between the nearest surface in slope, which refraction measures, and the nearest in height; map is the
// former, and what lies between them for a common mode of 1 mm is a column of doubt.
struct BoardMap {
  Eigen::MatrixXd map;       // board's modes x common modes
  Eigen::VectorXd constant;  // mm: the board's zero level is another
  Eigen::MatrixXd doubt;     // as map; zero where the map is exact
  bool exact = true;
};

// kInput when the board's modes cannot be told apart over its area.
[[nodiscard]] Outcome<BoardMap> map_to_board(const dsp::SurfaceModel<double>& common, const dsp::SurfaceModel<double>& board,
                                             const BoardPlacement& placement, const BoardArea& area);

}  // namespace srd::host
