// SPDX-License-Identifier: Apache-2.0
// OpenCV's lens with its derivatives for its own numbers: what an adjustment and an error's way need. Optics (3); the same
// pixels as CameraModel. Pure; nothing on the heap.
#pragma once

#include <array>
#include <span>

#include "dsp/optics/camera_model.hpp"

namespace srd::dsp {

inline constexpr int kMaxDistortion = 14;
inline constexpr int kPinhole = 4;  // fx fy cx cy, px, before the coefficients
inline constexpr int kMaxIntrinsics = kPinhole + kMaxDistortion;

// Intrinsics stand as fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty, cut after 4, 5, 8, 12 or 14 coefficients.
using IntrinsicsJacobian = Eigen::Matrix<double, 2, kMaxIntrinsics, Eigen::RowMajor>;
using IntrinsicsMatrix = Eigen::Matrix<double, kMaxIntrinsics, kMaxIntrinsics>;  // covariance

// Raw pixel of normalised undistorted coordinates. Jacobians: of the pixel for the first 4 + n intrinsics (the others
// stay as they are), and for xy.
[[nodiscard]] Vec2<double> lens_pixel(std::span<const double> intrinsics, const Vec2<double>& xy,
                                      IntrinsicsJacobian* by_intrinsics, Mat2<double>* by_xy);

// The camera's own, all 18.
[[nodiscard]] std::array<double, kMaxIntrinsics> intrinsics_of(const CameraModel<double>& camera);

}  // namespace srd::dsp
