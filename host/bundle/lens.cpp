// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/lens.hpp"

#include <algorithm>
#include <cmath>

namespace srd::bundle {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// OpenCV's tilted sensor, and how it changes with either angle.
struct Tilt {
  Matrix3d value, by_x, by_y;

  Tilt(double tx, double ty) {
    const double cx = std::cos(tx), sx = std::sin(tx), cy = std::cos(ty), sy = std::sin(ty);
    Matrix3d rx, ry, dx, dy;
    rx << 1, 0, 0, 0, cx, sx, 0, -sx, cx;
    ry << cy, 0, -sy, 0, 1, 0, sy, 0, cy;
    dx << 0, 0, 0, 0, -sx, cx, 0, -cx, -sx;
    dy << -sy, 0, -cy, 0, 0, 0, cy, 0, -sy;
    const Matrix3d r = ry * rx, r_x = ry * dx, r_y = dy * rx;
    const auto back = [](const Matrix3d& m, double last) {
      Matrix3d p;
      p << m(2, 2), 0, -m(0, 2), 0, m(2, 2), -m(1, 2), 0, 0, last;
      return p;
    };
    value = back(r, 1) * r;
    by_x = back(r_x, 0) * r + back(r, 1) * r_x;
    by_y = back(r_y, 0) * r + back(r, 1) * r_y;
  }
};

}  // namespace

bool is_coefficient_count(int n) { return n == 4 || n == 5 || n == 8 || n == 12 || n == 14; }

std::string intrinsic_name(int index) {
  static constexpr std::array<const char*, kMaxIntrinsics> kNames{"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3",
                                                                  "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tx", "ty"};
  return kNames[static_cast<std::size_t>(index)];
}

bool project(std::span<const double> intrinsics, const Vector3d& point, Vector2d& pixel, IntrinsicsJacobian* by_intrinsics,
             Eigen::Matrix<double, 2, 3>* by_point) {
  if (!(point.z() > 0)) return false;
  std::array<double, kMaxCoefficients> k{};
  const std::size_t n = intrinsics.size() - kPinhole;
  std::copy_n(intrinsics.begin() + kPinhole, n, k.begin());
  const double fx = intrinsics[0], fy = intrinsics[1];
  const double x = point.x() / point.z(), y = point.y() / point.z();
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double denominator = 1 + k[5] * r2 + k[6] * r4 + k[7] * r6;
  const double ratio = (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / denominator;
  Vector2d d(x * ratio + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + k[8] * r2 + k[9] * r4,
             y * ratio + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + k[10] * r2 + k[11] * r4);
  const Vector2d flat = d;

  const bool tilted = n == 14;
  const Tilt tilt = tilted ? Tilt(k[12], k[13]) : Tilt(0, 0);
  double hz = 1;
  if (tilted) {
    const Vector3d h = tilt.value * Vector3d(d.x(), d.y(), 1);
    hz = h.z();
    d = h.head<2>() / hz;
  }
  pixel = {fx * d.x() + intrinsics[2], fy * d.y() + intrinsics[3]};
  if (by_intrinsics == nullptr && by_point == nullptr) return true;

  // d (after the tilt) / d (before it), in px.
  Eigen::Matrix2d scale = Eigen::Matrix2d::Identity();
  if (tilted)
    for (int row = 0; row < 2; ++row)
      for (int column = 0; column < 2; ++column)
        scale(row, column) = (tilt.value(row, column) - d[row] * tilt.value(2, column)) / hz;
  scale.row(0) *= fx;
  scale.row(1) *= fy;

  if (by_intrinsics != nullptr) {
    IntrinsicsJacobian& j = *by_intrinsics;
    j.leftCols<kPinhole>() << d.x(), 0, 1, 0, 0, d.y(), 0, 1;
    Eigen::Matrix<double, 2, 12> c;
    c.col(0) = Vector2d(x, y) * (r2 / denominator);
    c.col(1) = Vector2d(x, y) * (r4 / denominator);
    c.col(2) = Vector2d(2 * x * y, r2 + 2 * y * y);
    c.col(3) = Vector2d(r2 + 2 * x * x, 2 * x * y);
    c.col(4) = Vector2d(x, y) * (r6 / denominator);
    for (int i = 0; i < 3; ++i) c.col(5 + i) = -ratio * c.col(i == 2 ? 4 : i);
    c.col(8) = Vector2d(r2, 0);
    c.col(9) = Vector2d(r4, 0);
    c.col(10) = Vector2d(0, r2);
    c.col(11) = Vector2d(0, r4);
    const int polynomial = std::min(static_cast<int>(n), 12);
    j.middleCols(kPinhole, polynomial) = scale * c.leftCols(polynomial);
    if (tilted) {
      const Vector3d v(flat.x(), flat.y(), 1);
      for (int axis = 0; axis < 2; ++axis) {
        const Vector3d h = (axis == 0 ? tilt.by_x : tilt.by_y) * v;
        const Vector2d moved = (h.head<2>() - d * h.z()) / hz;
        j.col(kPinhole + 12 + axis) = Vector2d(fx * moved.x(), fy * moved.y());
      }
    }
  }
  if (by_point != nullptr) {
    const double ratio_r2 =
        ((k[0] + 2 * k[1] * r2 + 3 * k[4] * r4) - ratio * (k[5] + 2 * k[6] * r2 + 3 * k[7] * r4)) / denominator;
    const double prism_x = k[8] + 2 * k[9] * r2, prism_y = k[10] + 2 * k[11] * r2;
    Eigen::Matrix2d undistorted;
    undistorted << ratio + 2 * x * x * ratio_r2 + 2 * k[2] * y + 6 * k[3] * x + 2 * x * prism_x,
        2 * x * y * ratio_r2 + 2 * k[2] * x + 2 * k[3] * y + 2 * y * prism_x,
        2 * x * y * ratio_r2 + 2 * k[2] * x + 2 * k[3] * y + 2 * x * prism_y,
        ratio + 2 * y * y * ratio_r2 + 6 * k[2] * y + 2 * k[3] * x + 2 * y * prism_y;
    Eigen::Matrix<double, 2, 3> perspective;
    perspective << 1, 0, -x, 0, 1, -y;
    *by_point = scale * undistorted * (perspective / point.z());
  }
  return true;
}

}  // namespace srd::bundle
