// SPDX-License-Identifier: Apache-2.0
// points.txt: the pattern's corners on the bottom.
#pragma once

#include <filesystem>
#include <vector>

#include "drivers/support/problem.hpp"
#include "dsp/optics/view.hpp"

namespace srd {

// Bottom points F, mm, in W.
using Points = std::vector<dsp::Vec3<double>>;

// x y z a line, white space or commas between; blank lines and '#' comments skipped; at least one point, none twice.
// kInput naming file and line.
[[nodiscard]] Outcome<Points> read_points(const std::filesystem::path& file);
[[nodiscard]] Outcome<void> write_points(const std::filesystem::path& file, const Points& points);

}  // namespace srd
