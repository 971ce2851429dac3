// SPDX-License-Identifier: Apache-2.0
// A pose as six numbers: turn as an angle about an axis (rad), then translation (mm): x_C = R(turn) x + t. Optics (1).
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <span>

#include "dsp/optics/view.hpp"

namespace srd::bundle {

inline constexpr int kPose = 6;
using PoseVector = Eigen::Matrix<double, kPose, 1>;

[[nodiscard]] inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// R(turn), and J with R(turn + d) = R(J d) R(turn) to first order (Barfoot, State Estimation for Robotics, 7.1).
struct Turn {
  Eigen::Matrix3d rotation, left_jacobian;

  explicit Turn(const Eigen::Vector3d& turn) {
    const double angle2 = turn.squaredNorm(), angle = std::sqrt(angle2);
    // sin a / a, (1 - cos a) / a^2 and (a - sin a) / a^3; short of cancellation their series.
    double first = 1 - angle2 / 6, second = 0.5 - angle2 / 24, third = 1.0 / 6 - angle2 / 120;
    if (angle > 1e-4) {
      const double half = std::sin(angle / 2) / angle;
      first = std::sin(angle) / angle;
      second = 2 * half * half;
      third = (1 - first) / angle2;
    }
    const Eigen::Matrix3d k = cross_matrix(turn), k2 = k * k;
    rotation = Eigen::Matrix3d::Identity() + first * k + second * k2;
    left_jacobian = Eigen::Matrix3d::Identity() + second * k + third * k2;
  }
};

[[nodiscard]] inline dsp::Pose<double> to_pose(const PoseVector& p) { return {Turn(p.head<3>()).rotation, p.tail<3>()}; }

[[nodiscard]] inline PoseVector to_vector(const dsp::Pose<double>& pose) {
  const Eigen::AngleAxisd turn(pose.rotation);
  PoseVector p;
  p << turn.angle() * turn.axis(), pose.translation;
  return p;
}

}  // namespace srd::bundle
