// SPDX-License-Identifier: Apache-2.0
// pose.yml: where a camera is, in OpenCV FileStorage keys as OpenSRD writes them: Rotationmatrix (orthonormal to 1e-3,
// determinant +1; re-orthonormalised) and TranslationVector (mm), which take points of W into the camera.
#pragma once

#include <filesystem>

#include "drivers/support/problem.hpp"
#include "dsp/optics/view.hpp"

namespace srd {

// kInput naming file and key.
[[nodiscard]] Outcome<dsp::Pose<double>> read_pose(const std::filesystem::path& file);
[[nodiscard]] Outcome<void> write_pose(const std::filesystem::path& file, const dsp::Pose<double>& pose);

}  // namespace srd
