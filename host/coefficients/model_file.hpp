// SPDX-License-Identifier: Apache-2.0
// F.csv.model.toml: the surface model behind the coefficients of F.csv, one [[node]] a node, lengths in mm:
//   [[node]]
//   name = "flume-1"
//   modes = ["A00", "B", "C"]
//   lx = 400.0
//   ly = 800.0
//   x0 = 0.0
//   y0 = 0.0
//   refractive_index = 1.333
//   pattern_x = [0.0, 200.0]
//   pattern_y = [0.0, 400.0]
//   [[node.plate]]             # floor plates from the top down
//   thickness_mm = 12.0
//   index = 1.49
//   [node.systematic]          # what the columns sys_ come from: errors of the pose, and of the calibration where it counts
//   pose = "2026-11-28"        # dates of the files; "" where a file has none
//   calibration = "2026-11-27"
// The pattern's extent, the plates and the sources may be missing where the writer does not know them; everything else is
// required.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/recording/recorded_optics.hpp"
#include "drivers/support/day.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/optics/surface_model.hpp"
#include "host/coefficients/pattern_extent.hpp"

namespace srd::host {

// Whose errors the systematic deviations hold.
struct ErrorSources {
  Day pose = 0;                      // date; 0: the file has none
  std::optional<Day> calibration{};  // none: the calibration counts as exact
  friend bool operator==(const ErrorSources&, const ErrorSources&) = default;
};

// "the pose of 2026-11-28; the calibration counts as exact"
[[nodiscard]] std::string sources_text(const ErrorSources& sources);

struct NodeModel {
  std::string node;
  dsp::SurfaceModel<double> model;
  double refractive_index = 1.333;  // of the water, against air 1
  std::optional<PatternExtent> pattern;
  Plates plates{};
  std::optional<ErrorSources> systematic{};  // none: no systematic deviations are known
};

struct ModelFile {
  std::vector<NodeModel> nodes;
  // nullptr when the file says nothing of it.
  [[nodiscard]] const NodeModel* find(std::string_view node) const;
};

// "run.csv" -> "run.csv.model.toml", in the same folder.
[[nodiscard]] std::filesystem::path model_file_path(const std::filesystem::path& csv);

// kUsage with file and line for a missing, unknown, wrong or repeated value.
[[nodiscard]] Outcome<ModelFile> read_model_file(const std::filesystem::path& file);
[[nodiscard]] Outcome<ModelFile> parse_model_file(std::string_view text, const std::string& name);

// The file's contents; reads back as the same numbers.
[[nodiscard]] std::string model_file_text(const ModelFile& model_file);
// Replaces the file at once (a reader sees the old or the new one). kInput when it cannot be written.
[[nodiscard]] Outcome<void> write_model_file(const std::filesystem::path& file, const ModelFile& model_file);

}  // namespace srd::host
