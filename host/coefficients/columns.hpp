// SPDX-License-Identifier: Apache-2.0
// The columns of a coefficient file, which srd listen and srd reconstruct write and every reader finds by name:
// node,boot,sequence,time_ns,clock,status,n_expected,n_found,n_used,mean_error,metric,height_mm,<modes>,sd_<modes>,
// wall_time_ns,wall_uncertainty_ns. time_ns is the sensor's; wall_time_ns the same moment since 1970 UTC, with its standard
// deviation, both empty where not known; height_mm lies at the pattern's centre. boot is a word, so that no program rounds it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "dsp/optics/surface_model.hpp"

namespace srd::host {

inline constexpr std::string_view kFixedColumns =
    "node,boot,sequence,time_ns,clock,status,n_expected,n_found,n_used,mean_error,metric,height_mm";
// Behind the modes and their deviations, so that whoever reads columns by their number finds those before where they were.
inline constexpr std::string_view kWallColumns = "wall_time_ns,wall_uncertainty_ns";

// With its line end.
[[nodiscard]] inline std::string coefficient_header(const dsp::ModeList& modes) {
  std::string header(kFixedColumns);
  for (const char* prefix : {",", ",sd_"})
    for (const dsp::Mode& mode : modes) header += prefix + std::string(mode.name().data());
  return header + "," + std::string(kWallColumns) + "\n";
}

// b and 16 hexadecimal digits: "b00000000000000ff".
[[nodiscard]] inline std::string boot_text(std::uint64_t boot) {
  std::string text(17, 'b');
  for (std::size_t i = 16; i > 0; --i, boot >>= 4U) text[i] = "0123456789abcdef"[boot & 15U];
  return text;
}

}  // namespace srd::host
