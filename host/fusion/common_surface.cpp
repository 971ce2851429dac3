// SPDX-License-Identifier: Apache-2.0
#include "host/fusion/common_surface.hpp"

#include <Eigen/QR>
#include <cmath>

namespace srd::host {
namespace {

// Nine harmonics need more than two places a half wave.
constexpr int kPlaces = 24;
// A map whose doubt stays below is exact: rounding of a board's lengths, which are floats on the wire.
constexpr double kRounding = 1e-5;

}  // namespace

dsp::Vec2<double> BoardPlacement::to_common(const dsp::Vec2<double>& board) const {
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  return {x_mm + c * board.x() - s * board.y(), y_mm + s * board.x() + c * board.y()};
}

Outcome<BoardMap> map_to_board(const dsp::SurfaceModel<double>& common, const dsp::SurfaceModel<double>& board,
                               const BoardPlacement& placement, const BoardArea& area) {
  const int n_board = board.modes.size(), n_common = common.modes.size();
  constexpr int kAll = kPlaces * kPlaces;
  // Heights in the upper rows; slopes along the board's X and Y, times the length that makes them mm, in the lower.
  Eigen::MatrixXd own(3 * kAll, n_board), given(3 * kAll, n_common);
  const double length = std::hypot(area.width_mm, area.height_mm) / 4;
  const double c = std::cos(placement.turn_rad), s = std::sin(placement.turn_rad);
  dsp::Basis<double> basis;
  for (int i = 0; i < kAll; ++i) {
    const dsp::Vec2<double> at(area.x_mm + area.width_mm * ((i % kPlaces + 0.5) / kPlaces - 0.5),
                               area.y_mm + area.height_mm * ((i / kPlaces + 0.5) / kPlaces - 0.5));
    board.basis(at.x(), at.y(), basis);
    own.row(i) = basis.value.transpose();
    own.row(kAll + i) = length * basis.dx.transpose();
    own.row(2 * kAll + i) = length * basis.dy.transpose();
    const dsp::Vec2<double> there = placement.to_common(at);
    common.basis(there.x(), there.y(), basis);
    given.row(i) = basis.value.transpose();
    given.row(kAll + i) = length * (c * basis.dx + s * basis.dy).transpose();
    given.row(2 * kAll + i) = length * (c * basis.dy - s * basis.dx).transpose();
  }
  const auto undetermined = [&] {
    return Problem{Exit::kInput, "a board's modes cannot be told apart over the area that it sees",
                   "",           "independent modes",
                   "",           "fewer modes in its configuration"};
  };
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> by_height(own.topRows(kAll));
  if (by_height.rank() < n_board) return undetermined();
  BoardMap out;
  const Eigen::MatrixXd height_map = by_height.solve(given.topRows(kAll));
  out.constant = by_height.solve(Eigen::VectorXd::Constant(kAll, -placement.z_mm));
  // The mean level gives no slope: a little of the heights holds it.
  constexpr double kLevel = 0.03;
  own.topRows(kAll) *= kLevel;
  given.topRows(kAll) *= kLevel;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> by_slope(own);
  if (by_slope.rank() < n_board) return undetermined();
  out.map = by_slope.solve(given);
  out.doubt = height_map - out.map;
  out.exact = out.doubt.cwiseAbs().maxCoeff() < kRounding;
  if (out.exact) out.doubt.setZero();
  return out;
}

}  // namespace srd::host
