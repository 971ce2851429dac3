// SPDX-License-Identifier: Apache-2.0
// Which files hold the frames of a camera, in chronological order.
#pragma once

#include <filesystem>
#include <vector>

#include "drivers/support/problem.hpp"
#include "host/opensrd/settings.hpp"

namespace srd::host::opensrd {

// Names are chronological (guide 3.2), in natural order; hidden files are left out. Warnings: where names can be read in two
// ways, the way taken. kInput: no folder, or nothing in it.
[[nodiscard]] Outcome<std::vector<std::filesystem::path>> image_files(const std::filesystem::path& folder,
                                                                      std::vector<std::string>& warnings);
[[nodiscard]] Outcome<std::vector<std::filesystem::path>> feature_files(const std::filesystem::path& folder,
                                                                        std::vector<std::string>& warnings);

// Frame_k.txt of an earlier run of these settings: out (its --out folder) or the folder of the files itself for a single
// camera. Frame_0 is the last frame where the dialect starts at the last. kInput: none there, or a number is missing.
[[nodiscard]] Outcome<std::vector<std::filesystem::path>> saved_features(const std::filesystem::path& out,
                                                                         const CameraSettings& camera, std::size_t camera_index,
                                                                         const Settings& settings);

}  // namespace srd::host::opensrd
