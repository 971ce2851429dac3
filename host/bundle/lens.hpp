// SPDX-License-Identifier: Apache-2.0
// OpenCV's lens as an adjustment sees it: points in the camera's frame to pixels. Optics (3).
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "dsp/optics/lens.hpp"

namespace srd::bundle {

using dsp::IntrinsicsJacobian;
using dsp::kMaxIntrinsics;
using dsp::kPinhole;

[[nodiscard]] bool is_coefficient_count(int n);
[[nodiscard]] std::string intrinsic_name(int index);

// Pixel of a point in the camera's frame (mm, z > 0). Jacobians: of the pixel, for the first 4 + n intrinsics (the
// others stay as they are), and for the point. false: not in front of the camera; nothing is written then.
[[nodiscard]] bool project(std::span<const double> intrinsics, const Eigen::Vector3d& point, Eigen::Vector2d& pixel,
                           IntrinsicsJacobian* by_intrinsics = nullptr, Eigen::Matrix<double, 2, 3>* by_point = nullptr);

}  // namespace srd::bundle
