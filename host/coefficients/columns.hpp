// SPDX-License-Identifier: Apache-2.0
// The columns of a coefficient file, which srd listen and srd reconstruct write and every reader finds by name:
// node,boot,sequence,time_ns,clock,status,n_expected,n_found,n_used,mean_error,metric,height_mm,<modes>,sd_<modes>,
// wall_time_ns,wall_uncertainty_ns,sys_<modes>,sys_height_mm. time_ns is the sensor's; wall_time_ns the same moment since 1970 UTC, with its standard
// deviation, both empty where not known; height_mm lies at the pattern's centre. sd_ is the
// random standard deviation of this frame, sys_ what the errors of calibration and pose leave alike in every frame; empty where
// not known, and files of earlier versions have no sys_ columns. boot is a word, so that no program rounds it.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/support/mode_names.hpp"
#include "dsp/estimate/residual/metric.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd::host {

inline constexpr std::string_view kFixedColumns =
    "node,boot,sequence,time_ns,clock,status,n_expected,n_found,n_used,mean_error,metric,height_mm";
// Behind the modes and their deviations, so that whoever reads columns by their number finds those before where they were.
inline constexpr std::string_view kWallColumns = "wall_time_ns,wall_uncertainty_ns";
// Behind these, for the same reason.
inline constexpr const char* kSystematicPrefix = "sys_";
inline constexpr const char* kSystematicHeight = "sys_height_mm";
// For messages.
inline const std::string kColumnsText = std::string(kFixedColumns) + ",<modes>,sd_<modes>";

// With its line end.
[[nodiscard]] inline std::string coefficient_header(const dsp::ModeList& modes) {
  return std::string(kFixedColumns) + "," + joined(modes, ",") + "," + joined(modes, ",", "sd_") + "," +
         std::string(kWallColumns) + "," + joined(modes, ",", kSystematicPrefix) + "," + kSystematicHeight + "\n";
}

// b and 16 hexadecimal digits: "b00000000000000ff".
[[nodiscard]] inline std::string boot_text(std::uint64_t boot) {
  std::string text(17, 'b');
  for (std::size_t i = 16; i > 0; --i, boot >>= 4U) text[i] = "0123456789abcdef"[boot & 15U];
  return text;
}

// As boot_text writes it, nothing else.
[[nodiscard]] inline std::optional<std::uint64_t> parse_boot(std::string_view cell) {
  std::uint64_t boot = 0;
  if (!cell.starts_with('b')) return std::nullopt;
  if (std::from_chars(cell.data() + 1, cell.data() + cell.size(), boot, 16).ec != std::errc{} || boot_text(boot) != cell)
    return std::nullopt;
  return boot;
}

// The metric column has a name of dsp::Metric, or this one of the pattern metric, whose errors are grey levels.
inline constexpr const char* kPatternMetric = "pattern";

// Unit of the mean_error column: "px", "mm", "rad", "grey levels"; empty for a metric that is not known.
[[nodiscard]] inline const char* error_unit(std::string_view metric) {
  if (metric == kPatternMetric) return "grey levels";
  const auto known = dsp::parse_metric(metric);
  return known ? dsp::unit(*known) : "";
}

}  // namespace srd::host
