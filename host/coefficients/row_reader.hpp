// SPDX-License-Identifier: Apache-2.0
// One node's coefficients from a CSV file of `srd listen` or `srd reconstruct`:
// columns as in columns.hpp, found by name; what earlier versions wrote and other programs saved again too.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/support/csv_table.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd::host {

// One frame. Without a surface: coefficients, deviations and height are NaN.
struct CoefficientRow {
  std::string boot;
  std::uint64_t sequence = 0;
  std::uint64_t dark_before = 0;  // frames without light, on purpose, since the row before: they are no rows
  std::int64_t time_ns = 0;
  std::string status;
  double corners_used = 0;                       // NaN where the file says nothing
  double mean_error = 0;                         // in the metric's unit
  double height_mm = 0;                          // at the pattern's centre; NaN where the file says nothing
  dsp::Coefficients<double> coefficients;        // mm, in the order of CoefficientRun::modes
  dsp::Coefficients<double> standard_deviation;  // mm; NaN where undetermined
  // What calibration and pose leave alike in every frame, mm; NaN where the file says nothing.
  dsp::Coefficients<double> systematic_deviation;
  double systematic_height = 0;

  [[nodiscard]] bool has_surface() const;
  // No surface, or one that the node itself doubts: status poor_fit, inconsistent, interlaced or not_converged.
  [[nodiscard]] bool is_flagged() const;
};

// Frames that should lie between two rows of one boot and do not.
[[nodiscard]] std::uint64_t missing_between(const CoefficientRow& before, const CoefficientRow& row);

struct CoefficientRun {
  std::string file;
  std::string node;
  std::string clock;   // of the first row
  std::string metric;  // of the first row with a surface
  dsp::ModeList modes;
  std::vector<CoefficientRow> rows;  // at least one; boots in the order of the file, each in order of sequence
  std::vector<std::string> notes;    // what a person should know: rows left out, a file cut short

  [[nodiscard]] std::size_t surfaces() const;
};

// node "": the only one in the file. kInput, naming file:line, for a missing column, a cell of the wrong
// kind, a row with some of its coefficients, a frame that is there twice, no rows at all; kUsage when the
// node has to be named.
[[nodiscard]] Outcome<CoefficientRun> read_coefficient_run(const std::filesystem::path& file, const std::string& node);
[[nodiscard]] Outcome<CoefficientRun> coefficient_run(const CsvTable& table, const std::string& file, const std::string& node);

// kInput, naming where the rows start and what their statuses are, when not one frame has a surface.
[[nodiscard]] Outcome<void> require_surface(const CoefficientRun& run);

}  // namespace srd::host
