// SPDX-License-Identifier: Apache-2.0
// Residuals of one corner for Ceres, with analytic derivatives: (projected - seen) / sigma, two numbers without unit.
// Parameter blocks: intrinsics (4 + coefficients), pose (6: board or world to camera), and the point or the bend.
// A point behind the camera: Evaluate is false, and Ceres shortens its step.
#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>

#include "host/bundle/board_shape.hpp"

namespace srd::bundle {

struct SeenCorner {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // raw, px
  double sigma = 1;                                 // standard deviation per axis, px
};

// Blocks: intrinsics, pose, point (3, mm).
class PointCost : public ceres::CostFunction {
 public:
  PointCost(const SeenCorner& seen, int coefficients);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  SeenCorner seen_;
};

// A corner of a bent board. Blocks: intrinsics, pose, bend (2, mm).
class BoardCost : public ceres::CostFunction {
 public:
  BoardCost(const SeenCorner& seen, int coefficients, const BoardShape& shape, int row, int column);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  SeenCorner seen_;
  Eigen::Vector3d flat_;
  Eigen::Vector2d weights_;
};

}  // namespace srd::bundle
