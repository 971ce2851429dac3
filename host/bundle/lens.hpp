// SPDX-License-Identifier: Apache-2.0
// OpenCV's lens with the derivatives that an adjustment needs. Optics (3); same numbers as dsp::CameraModel.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>

namespace srd::bundle {

inline constexpr int kMaxCoefficients = 14;
inline constexpr int kPinhole = 4;  // fx fy cx cy, px, before the coefficients
inline constexpr int kMaxIntrinsics = kPinhole + kMaxCoefficients;

// Intrinsics stand as fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty, cut after 4, 5, 8, 12 or 14 coefficients.
[[nodiscard]] bool is_coefficient_count(int n);
[[nodiscard]] std::string intrinsic_name(int index);

using IntrinsicsJacobian = Eigen::Matrix<double, 2, kMaxIntrinsics, Eigen::RowMajor>;

// Pixel of a point in the camera's frame (mm, z > 0). Jacobians: of the pixel, for the first 4 + n intrinsics (the
// others stay as they are), and for the point. false: not in front of the camera; nothing is written then.
[[nodiscard]] bool project(std::span<const double> intrinsics, const Eigen::Vector3d& point, Eigen::Vector2d& pixel,
                           IntrinsicsJacobian* by_intrinsics = nullptr, Eigen::Matrix<double, 2, 3>* by_point = nullptr);

}  // namespace srd::bundle
