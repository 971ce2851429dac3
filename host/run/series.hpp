// SPDX-License-Identifier: Apache-2.0
// The chronological result of a run: the CSV that `srd listen` writes too, its model beside it, and a summary to read.
#pragma once

#include <string>
#include <vector>

#include "host/run/run.hpp"

namespace srd::host {

// The columns of host/coefficients/columns.hpp. Empty cells where a frame has no surface.
[[nodiscard]] std::string series_csv(const RunPlan& plan, const RunResult& result);
// Modes, lengths, origin and refractive index of the series: the text of surface.csv.model.toml.
[[nodiscard]] std::string series_model(const RunPlan& plan, const RunResult& result);

// Of the frames with a surface.
struct RunMeans {
  std::size_t surfaces = 0;
  double error = 0;             // of the frames' mean errors, in the metric's unit
  double height_mm = 0;         // over the pattern's points and the frames
  double reprojection_rms = 0;  // px, per axis
  double seconds_a_frame = 0;   // of all frames
};
[[nodiscard]] RunMeans means(const RunPlan& plan, const RunResult& result);
// Mean height over the pattern's points, mm.
[[nodiscard]] double pattern_height(const RunPlan& plan, const dsp::Coefficients<double>& surface);

[[nodiscard]] const char* metric_name(const RunPlan& plan);
[[nodiscard]] const char* metric_unit(const RunPlan& plan);

// head: what was run on what, line by line.
[[nodiscard]] std::string summary_text(const RunPlan& plan, const RunResult& result, const std::vector<std::string>& head,
                                       const std::vector<std::string>& warnings);
// surface.csv, its model beside it and the summary.
[[nodiscard]] Outcome<void> write_series(const std::filesystem::path& series, const std::filesystem::path& summary,
                                         const RunPlan& plan, const RunResult& result, const std::vector<std::string>& head,
                                         const std::vector<std::string>& warnings);

}  // namespace srd::host
