// SPDX-License-Identifier: Apache-2.0
// A camera from views of one board: least squares over lens, poses and the board's shape, corners weighted by their
// deviations, with the covariance of everything. Ceres solves it: a Schur complement over the poses, for a handful of
// numbers of a bend as well as for hundreds of a free board, in code that others have tested for years.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"
#include "host/bundle/board_shape.hpp"
#include "host/bundle/rigid.hpp"

namespace srd::bundle {

struct ViewCorner {
  int row = 0, column = 0;                          // of the board
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // raw, px
  double sigma = 1;                                 // per axis, px, > 0
};

struct BoardView {
  std::string name;  // for messages
  std::vector<ViewCorner> corners;
};

enum class Surface : std::uint8_t {
  kFlat,
  kBent,  // two numbers, see BoardShape
  kFree,  // every corner has its own place, near to where the bent board would have it
};

struct CameraOptions {
  int coefficients = 5;  // 4, 5, 8, 12 or 14
  Surface surface = Surface::kBent;
  double print_mm = 0.05, unevenness_mm = 0.3;  // kFree: prior deviations of a corner in the board and across it
  // Corners whose residual is beyond so many robust deviations are left out; 0: none. Of 2000 good corners 0.007 are.
  double reject = 5;
};

struct ViewFit {
  PoseVector pose;                         // board to camera
  std::vector<Eigen::Vector2d> residuals;  // projected - seen, px, one a corner
  std::vector<char> used;                  // 0: left out as an outlier
  double rms_px = 0;                       // per axis, of what is used
  // See view_influence.hpp.
  double share = 0, contradiction = 0, moved = 0;
};

struct CameraFit {
  std::vector<double> intrinsics;  // 4 + coefficients, as lens.hpp has them
  std::vector<ViewFit> views;
  Surface surface = Surface::kFlat;
  Eigen::Vector2d bend = Eigen::Vector2d::Zero();  // mm
  std::vector<Eigen::Vector3d> points;             // the board's corners, row by row, mm
  // Of intrinsics, poses in the order of the views, then bend or points; scaled by the variance factor.
  Eigen::MatrixXd covariance;
  double rms_px = 0;           // per axis, of what is used
  int used = 0, rejected = 0;  // corners
  int freedom = 0;             // residuals less parameters
  double chi_square = 0;       // of the residuals against the stated deviations and added_px
  double stated_ratio = 0;     // residuals against the stated deviations alone, as a deviation: 1 when these say it all
  double added_px = 0;         // deviation that was added to every corner's own, so that the residuals are as large as stated
  double variance_factor = 1;  // chi_square / freedom: in the covariance
  // How much more the views contradict each other than independent corners would; where that is more than chance, the
  // covariance has it too.
  double view_factor = 1;
  bool views_contradict = false;
  double weakness = 0;  // least eigenvalue of the scaled information, see covariance.hpp
  int iterations = 0;

  [[nodiscard]] int lens_size() const { return static_cast<int>(intrinsics.size()); }
  [[nodiscard]] int view_at(std::size_t view) const { return lens_size() + kPose * static_cast<int>(view); }
  [[nodiscard]] int board_at() const { return view_at(views.size()); }
  [[nodiscard]] double deviation(int parameter) const;
};

// kInput: fewer than 4 corners in a view, data that do not determine the parameters, or a start that leads nowhere.
[[nodiscard]] Outcome<CameraFit> solve_camera(const BoardShape& shape, const std::vector<BoardView>& views, int image_width,
                                              int image_height, const CameraOptions& options);

}  // namespace srd::bundle
