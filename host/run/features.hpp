// SPDX-License-Identifier: Apache-2.0
// Feature files as OpenSRD writes them: "id u v" a line, undistorted pixel coordinates.
#pragma once

#include <filesystem>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd::host {

struct Feature {
  int id = 0;           // which line of the camera's file of feature points, from 0
  double u = 0, v = 0;  // undistorted: K applied to the normalised coordinates, px
};

// kInput, with the line: not three numbers, an id outside 0..point_count - 1 or given twice, a coordinate beyond 1e5 px.
// An empty file is a frame without features.
[[nodiscard]] Outcome<std::vector<Feature>> read_features(const std::filesystem::path& file, int point_count);
[[nodiscard]] Outcome<void> write_features(const std::filesystem::path& file, const std::vector<Feature>& features);

}  // namespace srd::host
