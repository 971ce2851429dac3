// SPDX-License-Identifier: Apache-2.0
// optics.toml of a recording: what the light went through and which surface was fitted, for whoever measures the same
// images again. Names and units are those of srd-node's configuration:
//   [water]
//   refractive_index = 1.333
//   [[water.plate]]            # from the top down; an air gap is a plate of index 1
//   thickness_mm = 12.0
//   index = 1.49
//   [surface]                  # may be missing: the writer knows none
//   modes = ["A00", "B", "C"]
//   lx_mm = 400.0
//   ly_mm = 800.0
//   x0_mm = 0.0
//   y0_mm = 0.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/support/problem.hpp"
#include "drivers/support/toml_reader.hpp"
#include "dsp/optics/media.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd {

inline constexpr std::string_view kOpticsName = "optics.toml";

struct RecordedOptics {
  dsp::Media<double> media;
  std::optional<dsp::SurfaceModel<double>> model;
};

// Nothing: the recording has no optics.toml. kInput with file and line for a wrong one.
[[nodiscard]] Outcome<std::optional<RecordedOptics>> read_recorded_optics(const std::filesystem::path& folder);
// Reads back as the same numbers.
[[nodiscard]] Outcome<void> write_recorded_optics(const std::filesystem::path& folder, const RecordedOptics& optics);

using Plates = std::vector<dsp::Layer<double>>;  // from the top down

// [[plate]] thickness_mm, index of a table; complains of what is missing or wrong, and of more than dsp::kMaxLayers.
[[nodiscard]] Plates read_plates(TomlTable& table);
// The same as text, each under [[heading]].
[[nodiscard]] std::string plates_toml(std::string_view heading, const Plates& plates);
// "THICKNESS,INDEX" each, mm. kUsage naming option for a wrong one.
[[nodiscard]] Outcome<Plates> parse_plates(std::span<const std::string> texts, const std::string& option);

[[nodiscard]] Plates plates_of(const dsp::Media<double>& media);
// plates: at most dsp::kMaxLayers.
void set_plates(dsp::Media<double>& media, const Plates& plates);
[[nodiscard]] bool same_plates(const Plates& a, const Plates& b);
// "no floor plates", or "floor plates 12 mm of index 1.49, 2 mm of index 1 (from the top down)".
[[nodiscard]] std::string plates_text(const Plates& plates);

}  // namespace srd
