// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/corner_costs.hpp"

#include "host/bundle/lens.hpp"
#include "host/bundle/rigid.hpp"

namespace srd::bundle {

namespace {

using Rows2 = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
using Point2 = Eigen::Matrix<double, 2, 3>;

// Residual, and its derivatives for intrinsics and pose as Ceres asks for them; by_point for the rest.
bool corner_residual(const SeenCorner& seen, std::span<const double> intrinsics, const double* pose,
                     const Eigen::Vector3d& point, double* residuals, double** jacobians, Point2* by_point) {
  const Eigen::Map<const PoseVector> p(pose);
  const Turn turn(p.head<3>());
  const Eigen::Vector3d turned = turn.rotation * point;
  const bool derive = jacobians != nullptr;
  IntrinsicsJacobian by_intrinsics;
  Point2 by_camera_point;
  Eigen::Vector2d pixel;
  if (!project(intrinsics, turned + p.tail<3>(), pixel, derive && jacobians[0] != nullptr ? &by_intrinsics : nullptr,
               derive ? &by_camera_point : nullptr))
    return false;
  Eigen::Map<Eigen::Vector2d>{residuals} = (pixel - seen.pixel) / seen.sigma;
  if (!derive) return true;
  const double weight = 1 / seen.sigma;
  const auto n = static_cast<Eigen::Index>(intrinsics.size());
  if (jacobians[0] != nullptr) Eigen::Map<Rows2>(jacobians[0], 2, n) = weight * by_intrinsics.leftCols(n);
  if (jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 2, kPose, Eigen::RowMajor>> j(jacobians[1]);
    j.leftCols<3>() = -weight * by_camera_point * cross_matrix(turned) * turn.left_jacobian;
    j.rightCols<3>() = weight * by_camera_point;
  }
  if (by_point != nullptr) *by_point = weight * by_camera_point * turn.rotation;
  return true;
}

}  // namespace

PointCost::PointCost(const SeenCorner& seen, int coefficients) : seen_(seen) {
  set_num_residuals(2);
  *mutable_parameter_block_sizes() = {kPinhole + coefficients, kPose, 3};
}

bool PointCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const std::span intrinsics(parameters[0], static_cast<std::size_t>(parameter_block_sizes()[0]));
  Point2 by_point;
  if (!corner_residual(seen_, intrinsics, parameters[1], Eigen::Map<const Eigen::Vector3d>(parameters[2]), residuals, jacobians,
                       &by_point))
    return false;
  if (jacobians != nullptr && jacobians[2] != nullptr)
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>{jacobians[2]} = by_point;
  return true;
}

BoardCost::BoardCost(const SeenCorner& seen, int coefficients, const BoardShape& shape, int row, int column)
    : seen_(seen), flat_(shape.flat(row, column)), weights_(shape.bend_weights(row, column)) {
  set_num_residuals(2);
  *mutable_parameter_block_sizes() = {kPinhole + coefficients, kPose, kBend};
}

bool BoardCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const std::span intrinsics(parameters[0], static_cast<std::size_t>(parameter_block_sizes()[0]));
  const Eigen::Map<const Eigen::Vector2d> bend(parameters[2]);
  const Eigen::Vector3d point = flat_ + Eigen::Vector3d(0, 0, bend.dot(weights_));
  Point2 by_point;
  if (!corner_residual(seen_, intrinsics, parameters[1], point, residuals, jacobians, &by_point)) return false;
  if (jacobians != nullptr && jacobians[2] != nullptr)
    Eigen::Map<Eigen::Matrix<double, 2, kBend, Eigen::RowMajor>>{jacobians[2]} = by_point.col(2) * weights_.transpose();
  return true;
}

}  // namespace srd::bundle
