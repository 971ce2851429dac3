// SPDX-License-Identifier: Apache-2.0
// pose.yml: where a camera is, in OpenCV FileStorage keys as OpenSRD writes them: Rotationmatrix (orthonormal to 1e-3,
// determinant +1; re-orthonormalised) and TranslationVector (mm), which take points of W into the camera; and, where it is known,
// further keys that other readers pass over: pose_covariance (6 x 6), pose_by_calibration (6 x 18) and pose_date.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "drivers/support/day.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/optics/view.hpp"
#include "dsp/pose/pose_fit.hpp"

namespace srd {

// kInput naming file and key.
[[nodiscard]] Outcome<dsp::Pose<double>> read_pose(const std::filesystem::path& file);

// Of a turn about the camera's axes (rad) and a shift of T (mm): x_C = exp([turn]x) R X + T + shift.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;
// How sure a pose is.
struct PoseErrors {
  PoseCovariance covariance = PoseCovariance::Zero();  // if the calibration is right that the pose was found with
  // d pose / d intrinsics of that calibration; none: not known.
  std::optional<dsp::PoseByIntrinsics> by_calibration{};
  Day date = 0;
};
[[nodiscard]] Outcome<void> write_pose(const std::filesystem::path& file, const dsp::Pose<double>& pose,
                                       const std::optional<PoseErrors>& errors = {});
// Nothing when the file has none. kInput for a covariance that is not symmetric or has a negative variance.
[[nodiscard]] Outcome<std::optional<PoseErrors>> read_pose_errors(const std::filesystem::path& file);

}  // namespace srd
