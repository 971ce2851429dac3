// SPDX-License-Identifier: Apache-2.0
// The file that says which boards see one surface, and where each of them lies. TOML:
//
//   [fusion]                id = "fused", pair_ms = 5: both optional
//   [surface]               optional, the common one: modes = ["A00", "B", ..] or parameters = 5, lx_mm, ly_mm, x0_mm, y0_mm
//   [[board]]               node = "flume-a", x_mm, y_mm, z_mm, turn_deg (0 where not given), clock_sd_ms
#pragma once

#include <filesystem>

#include "host/fusion/fusion.hpp"

namespace srd::host {

// Fills id, pair_ms, model and boards of the options. kUsage, with every fault of the file.
[[nodiscard]] Outcome<void> read_fusion_file(const std::filesystem::path& file, FusionOptions& options);

}  // namespace srd::host
