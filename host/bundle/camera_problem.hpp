// SPDX-License-Identifier: Apache-2.0
// The numbers of an adjustment and the Ceres problem over them.
#pragma once

#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "host/bundle/camera_solve.hpp"
#include "host/bundle/covariance.hpp"

namespace srd::bundle {

// The state that is adjusted. The problem points into it: it must not move while a problem lives.
struct CameraState {
  std::vector<double> intrinsics;
  std::vector<PoseVector> poses;
  Eigen::Vector2d bend = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector3d> points;  // of a free board
};

// How a corner counts in one round.
struct Weighting {
  std::vector<std::vector<char>> used;  // view, corner
  double added_px = 0;
  double robust = 0;  // scale of Cauchy's loss in deviations; 0: plain least squares
};

[[nodiscard]] std::unique_ptr<ceres::Problem> make_problem(const BoardShape& shape, const std::vector<BoardView>& views,
                                                           const CameraOptions& options, const Weighting& weighting,
                                                           CameraState& state);
// In the order of CameraFit::covariance.
[[nodiscard]] std::vector<Block> blocks_of(CameraState& state, Surface surface);
// Iterations taken; nothing when it ends without a finite cost or far from a minimum.
[[nodiscard]] Result<int> minimise(ceres::Problem& problem, CameraState& state);
// Projected less seen, px; a corner behind the camera is 1e9 px off.
[[nodiscard]] std::vector<std::vector<Eigen::Vector2d>> residuals_of(const BoardShape& shape,
                                                                     const std::vector<BoardView>& views,
                                                                     const CameraState& state);

}  // namespace srd::bundle
