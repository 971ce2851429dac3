// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/lens.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace srd::dsp {

namespace {

// OpenCV's tilted sensor, and how it changes with either angle.
struct Tilt {
  Mat3<double> value, by_x, by_y;

  Tilt(double tx, double ty) {
    const double cx = std::cos(tx), sx = std::sin(tx), cy = std::cos(ty), sy = std::sin(ty);
    Mat3<double> rx, ry, dx, dy;
    rx << 1, 0, 0, 0, cx, sx, 0, -sx, cx;
    ry << cy, 0, -sy, 0, 1, 0, sy, 0, cy;
    dx << 0, 0, 0, 0, -sx, cx, 0, -cx, -sx;
    dy << -sy, 0, -cy, 0, 0, 0, cy, 0, -sy;
    const Mat3<double> r = ry * rx, r_x = ry * dx, r_y = dy * rx;
    const auto back = [](const Mat3<double>& m, double last) {
      Mat3<double> p;
      p << m(2, 2), 0, -m(0, 2), 0, m(2, 2), -m(1, 2), 0, 0, last;
      return p;
    };
    value = back(r, 1) * r;
    by_x = back(r_x, 0) * r + back(r, 1) * r_x;
    by_y = back(r_y, 0) * r + back(r, 1) * r_y;
  }
};

}  // namespace

Vec2<double> lens_pixel(std::span<const double> intrinsics, const Vec2<double>& xy, IntrinsicsJacobian* by_intrinsics,
                        Mat2<double>* by_xy) {
  std::array<double, kMaxDistortion> k{};
  const std::size_t n = intrinsics.size() - kPinhole;
  std::copy_n(intrinsics.begin() + kPinhole, n, k.begin());
  const double fx = intrinsics[0], fy = intrinsics[1];
  const double x = xy.x(), y = xy.y();
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double denominator = 1 + k[5] * r2 + k[6] * r4 + k[7] * r6;
  const double ratio = (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / denominator;
  Vec2<double> d(x * ratio + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + k[8] * r2 + k[9] * r4,
                 y * ratio + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + k[10] * r2 + k[11] * r4);
  const Vec2<double> flat = d;

  const bool tilted = n == kMaxDistortion;
  const Tilt tilt = tilted ? Tilt(k[12], k[13]) : Tilt(0, 0);
  double hz = 1;
  if (tilted) {
    const Vec3<double> h = tilt.value * Vec3<double>(d.x(), d.y(), 1);
    hz = h.z();
    d = h.head<2>() / hz;
  }
  const Vec2<double> pixel(fx * d.x() + intrinsics[2], fy * d.y() + intrinsics[3]);
  if (by_intrinsics == nullptr && by_xy == nullptr) return pixel;

  // d (after the tilt) / d (before it), in px.
  Mat2<double> scale = Mat2<double>::Identity();
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
    c.col(0) = xy * (r2 / denominator);
    c.col(1) = xy * (r4 / denominator);
    c.col(2) = Vec2<double>(2 * x * y, r2 + 2 * y * y);
    c.col(3) = Vec2<double>(r2 + 2 * x * x, 2 * x * y);
    c.col(4) = xy * (r6 / denominator);
    for (int i = 0; i < 3; ++i) c.col(5 + i) = -ratio * c.col(i == 2 ? 4 : i);
    c.col(8) = Vec2<double>(r2, 0);
    c.col(9) = Vec2<double>(r4, 0);
    c.col(10) = Vec2<double>(0, r2);
    c.col(11) = Vec2<double>(0, r4);
    for (int i = 0; i < std::min(static_cast<int>(n), 12); ++i) j.col(kPinhole + i) = scale * c.col(i);
    if (tilted) {
      const Vec3<double> v(flat.x(), flat.y(), 1);
      for (int axis = 0; axis < 2; ++axis) {
        const Vec3<double> h = (axis == 0 ? tilt.by_x : tilt.by_y) * v;
        const Vec2<double> moved = (h.head<2>() - d * h.z()) / hz;
        j.col(kPinhole + 12 + axis) = Vec2<double>(fx * moved.x(), fy * moved.y());
      }
    }
  }
  if (by_xy != nullptr) {
    const double ratio_r2 =
        ((k[0] + 2 * k[1] * r2 + 3 * k[4] * r4) - ratio * (k[5] + 2 * k[6] * r2 + 3 * k[7] * r4)) / denominator;
    const double prism_x = k[8] + 2 * k[9] * r2, prism_y = k[10] + 2 * k[11] * r2;
    Mat2<double> undistorted;
    undistorted << ratio + 2 * x * x * ratio_r2 + 2 * k[2] * y + 6 * k[3] * x + 2 * x * prism_x,
        2 * x * y * ratio_r2 + 2 * k[2] * x + 2 * k[3] * y + 2 * y * prism_x,
        2 * x * y * ratio_r2 + 2 * k[2] * x + 2 * k[3] * y + 2 * x * prism_y,
        ratio + 2 * y * y * ratio_r2 + 6 * k[2] * y + 2 * k[3] * x + 2 * y * prism_y;
    *by_xy = scale * undistorted;
  }
  return pixel;
}

std::array<double, kMaxIntrinsics> intrinsics_of(const CameraModel<double>& camera) {
  std::array<double, kMaxIntrinsics> all{camera.fx(), camera.fy(), camera.cx(), camera.cy()};
  std::copy(camera.distortion().begin(), camera.distortion().end(), all.begin() + kPinhole);
  return all;
}

}  // namespace srd::dsp
