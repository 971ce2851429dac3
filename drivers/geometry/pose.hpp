// SPDX-License-Identifier: Apache-2.0
// pose.yml: where a camera is, in OpenCV FileStorage keys as OpenSRD writes them: Rotationmatrix (orthonormal to 1e-3,
// determinant +1; re-orthonormalised) and TranslationVector (mm), which take points of W into the camera; and, where it is known,
// a further key that other readers pass over: pose_covariance.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "drivers/support/problem.hpp"
#include "dsp/optics/view.hpp"

namespace srd {

// kInput naming file and key.
[[nodiscard]] Outcome<dsp::Pose<double>> read_pose(const std::filesystem::path& file);
[[nodiscard]] Outcome<void> write_pose(const std::filesystem::path& file, const dsp::Pose<double>& pose);
// Of a turn about the camera's axes (rad) and a shift of T (mm): x_C = exp([turn]x) R X + T + shift.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;
[[nodiscard]] Outcome<void> write_pose(const std::filesystem::path& file, const dsp::Pose<double>& pose,
                                       const PoseCovariance& covariance);
// Nothing when the file has none. kInput for one that is not symmetric or has a negative variance.
[[nodiscard]] Outcome<std::optional<PoseCovariance>> read_pose_covariance(const std::filesystem::path& file);

}  // namespace srd
