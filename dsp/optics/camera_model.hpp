// SPDX-License-Identifier: Apache-2.0
// Pinhole camera with OpenCV's distortion, and its inverse by Newton. Optics (3).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "dsp/core/lanes.hpp"
#include "dsp/core/linear_algebra.hpp"
#include "dsp/core/result.hpp"

namespace srd::dsp {

// Intrinsics in px; distortion k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty, zero-filled.
template <class S>
class CameraModel {
 public:
  CameraModel() = default;

  // distortion: 0, 4, 5, 8, 12 or 14 numbers. kInvalidArgument for another length, a focal length <= 0, or a NaN.
  [[nodiscard]] static Result<CameraModel> make(double fx, double fy, double cx, double cy, std::span<const double> distortion);

  template <class T>
  [[nodiscard]] CameraModel<T> cast() const {
    std::array<double, 14> k{};
    std::copy(k_.begin(), k_.end(), k.begin());
    return CameraModel<T>::make(static_cast<double>(fx_), static_cast<double>(fy_), static_cast<double>(cx_),
                                static_cast<double>(cy_), k)
        .value();
  }

  [[nodiscard]] S fx() const { return fx_; }
  [[nodiscard]] S fy() const { return fy_; }
  [[nodiscard]] S cx() const { return cx_; }
  [[nodiscard]] S cy() const { return cy_; }
  [[nodiscard]] const std::array<S, 14>& distortion() const { return k_; }

  // Undistorted to distorted normalised coordinates; jacobian = d distorted / d undistorted. Optics (3).
  [[nodiscard]] Vec2<S> distort(const Vec2<S>& undistorted, Mat2<S>* jacobian = nullptr) const;

  // Normalised undistorted coordinates to the raw pixel; jacobian = d pixel / d normalised.
  [[nodiscard]] Vec2<S> pixel(const Vec2<S>& undistorted, Mat2<S>* jacobian = nullptr) const;

  // Raw pixel to normalised undistorted coordinates, |residual| <= 1e-9 (double) or 4 ulp (float).
  // kNotConverged where the distortion cannot be inverted (outside the calibrated field).
  [[nodiscard]] Result<Vec2<S>> undistort(const Vec2<S>& raw_pixel) const;

 private:
  // OpenCV's tilted sensor: projection of R_y(ty) R_x(tx) back along z.
  void set_tilt();

  S fx_ = 1, fy_ = 1, cx_ = 0, cy_ = 0;
  std::array<S, 14> k_{};
  bool tilted_ = false;
  Mat3<S> tilt_ = Mat3<S>::Identity();
};

template <class S>
Result<CameraModel<S>> CameraModel<S>::make(double fx, double fy, double cx, double cy, std::span<const double> distortion) {
  const std::size_t n = distortion.size();
  if (n != 0 && n != 4 && n != 5 && n != 8 && n != 12 && n != 14) return Errc::kInvalidArgument;
  for (const double x : {fx, fy, cx, cy})
    if (!std::isfinite(x)) return Errc::kInvalidArgument;
  if (fx <= 0 || fy <= 0) return Errc::kInvalidArgument;
  CameraModel camera;
  camera.fx_ = static_cast<S>(fx);
  camera.fy_ = static_cast<S>(fy);
  camera.cx_ = static_cast<S>(cx);
  camera.cy_ = static_cast<S>(cy);
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(distortion[i])) return Errc::kInvalidArgument;
    camera.k_[i] = static_cast<S>(distortion[i]);
  }
  camera.set_tilt();
  return camera;
}

template <class S>
Vec2<S> CameraModel<S>::distort(const Vec2<S>& undistorted, Mat2<S>* jacobian) const {
  const S x = undistorted.x(), y = undistorted.y();
  const S r2 = x * x + y * y, r4 = r2 * r2;
  const S numerator = 1 + r2 * (k_[0] + r2 * (k_[1] + r2 * k_[4]));
  const S denominator = 1 + r2 * (k_[5] + r2 * (k_[6] + r2 * k_[7]));
  const S ratio = numerator / denominator;
  Vec2<S> d(x * ratio + 2 * k_[2] * x * y + k_[3] * (r2 + 2 * x * x) + k_[8] * r2 + k_[9] * r4,
            y * ratio + k_[2] * (r2 + 2 * y * y) + 2 * k_[3] * x * y + k_[10] * r2 + k_[11] * r4);
  if (jacobian != nullptr) {
    const S numerator_r2 = k_[0] + r2 * (2 * k_[1] + 3 * k_[4] * r2);
    const S denominator_r2 = k_[5] + r2 * (2 * k_[6] + 3 * k_[7] * r2);
    const S ratio_r2 = (numerator_r2 - ratio * denominator_r2) / denominator;
    const S prism_x = k_[8] + 2 * k_[9] * r2, prism_y = k_[10] + 2 * k_[11] * r2;
    (*jacobian)(0, 0) = ratio + 2 * x * x * ratio_r2 + 2 * k_[2] * y + 6 * k_[3] * x + 2 * x * prism_x;
    (*jacobian)(0, 1) = 2 * x * y * ratio_r2 + 2 * k_[2] * x + 2 * k_[3] * y + 2 * y * prism_x;
    (*jacobian)(1, 0) = 2 * x * y * ratio_r2 + 2 * k_[2] * x + 2 * k_[3] * y + 2 * x * prism_y;
    (*jacobian)(1, 1) = ratio + 2 * y * y * ratio_r2 + 6 * k_[2] * y + 2 * k_[3] * x + 2 * y * prism_y;
  }
  if (tilted_) {
    const Vec3<S> h = tilt_ * Vec3<S>(d.x(), d.y(), 1);
    d = h.template head<2>() / h.z();
    if (jacobian != nullptr) {
      Mat2<S> homography;
      for (int row = 0; row < 2; ++row)
        for (int column = 0; column < 2; ++column)
          homography(row, column) = (tilt_(row, column) - d[row] * tilt_(2, column)) / h.z();
      *jacobian = (homography * *jacobian).eval();
    }
  }
  return d;
}

template <class S>
Vec2<S> CameraModel<S>::pixel(const Vec2<S>& undistorted, Mat2<S>* jacobian) const {
  const Vec2<S> d = distort(undistorted, jacobian);
  if (jacobian != nullptr) {
    jacobian->row(0) *= fx_;
    jacobian->row(1) *= fy_;
  }
  return {fx_ * d.x() + cx_, fy_ * d.y() + cy_};
}

template <class S>
Result<Vec2<S>> CameraModel<S>::undistort(const Vec2<S>& raw_pixel) const {
  const Vec2<S> target((raw_pixel.x() - cx_) / fx_, (raw_pixel.y() - cy_) / fy_);
  if (!std::isfinite(target.x()) || !std::isfinite(target.y())) return Errc::kInvalidArgument;
  const S tolerance = std::max(S(1e-12), 4 * std::numeric_limits<S>::epsilon() * (1 + target.norm()));
  Vec2<S> x = target;
  Mat2<S> jacobian;
  Vec2<S> residual = distort(x, &jacobian) - target;
  S size = residual.norm();
  for (int iteration = 0; iteration < 50 && size > tolerance; ++iteration) {
    const S det = jacobian(0, 0) * jacobian(1, 1) - jacobian(0, 1) * jacobian(1, 0);
    if (!(std::abs(det) > std::numeric_limits<S>::min())) return Errc::kNotConverged;
    const Vec2<S> step((jacobian(1, 1) * residual.x() - jacobian(0, 1) * residual.y()) / det,
                       (jacobian(0, 0) * residual.y() - jacobian(1, 0) * residual.x()) / det);
    // A full step may jump over a pole of the rational part: halve it until the residual shrinks.
    S length = 1;
    bool shrunk = false;
    for (int halving = 0; halving < 12; ++halving, length /= 2) {
      const Vec2<S> trial = x - length * step;
      Mat2<S> trial_jacobian;
      const Vec2<S> trial_residual = distort(trial, &trial_jacobian) - target;
      const S trial_size = trial_residual.norm();
      if (trial_size < size) {
        x = trial;
        jacobian = trial_jacobian;
        residual = trial_residual;
        size = trial_size;
        shrunk = true;
        break;
      }
    }
    if (!shrunk) break;
  }
  const S accepted = std::max(S(1e-9), tolerance);
  if (!(size <= accepted)) return Errc::kNotConverged;
  // Beyond the fold of the distortion curve two field points share a pixel; orientation tells them apart.
  if (!(jacobian(0, 0) * jacobian(1, 1) - jacobian(0, 1) * jacobian(1, 0) > 0)) return Errc::kNotConverged;
  return x;
}

template <class S>
void CameraModel<S>::set_tilt() {
  tilted_ = k_[12] != 0 || k_[13] != 0;
  if (!tilted_) return;
  S cx, sx, cy, sy;
  sin_cos(k_[12], sx, cx);
  sin_cos(k_[13], sy, cy);
  Mat3<S> rotation_x, rotation_y, projection;
  rotation_x << 1, 0, 0, 0, cx, sx, 0, -sx, cx;
  rotation_y << cy, 0, -sy, 0, 1, 0, sy, 0, cy;
  const Mat3<S> r = rotation_y * rotation_x;
  projection << r(2, 2), 0, -r(0, 2), 0, r(2, 2), -r(1, 2), 0, 0, 1;
  tilt_ = projection * r;
}

extern template class CameraModel<float>;
extern template class CameraModel<double>;

}  // namespace srd::dsp
