// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/recorded_optics.hpp"

#include <algorithm>

#include "drivers/support/limits.hpp"
#include "drivers/support/mode_names.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

namespace fs = std::filesystem;

constexpr double kThickestMm = 1000;
constexpr double kMaxIndex = 3;

// With a point, so that TOML keeps it a real number.
std::string real(double x) {
  std::string text = number_text(x);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

double required(TomlTable& table, std::string_view key, const NumberRange& range, const std::string& meaning) {
  const auto value = table.number(key, range);
  if (!value && !table.has(key)) table.missing(key, meaning);
  return value.value_or(range.least);
}

std::optional<dsp::SurfaceModel<double>> read_model(TomlTable& surface) {
  const auto names = surface.texts("modes");
  if (!names && !surface.has("modes")) surface.missing("modes", "a list of mode names, as [\"A00\", \"B\", \"C\"]");
  std::vector<dsp::Mode> modes;
  for (const std::string& name : names.value_or(std::vector<std::string>{}))
    if (const auto mode = dsp::Mode::parse(name)) modes.push_back(*mode);
  const auto list = dsp::ModeList::make(modes);
  if (names && (!list || modes.size() != names->size()))
    surface.complain("modes", "1 to " + std::to_string(dsp::kMaxModes) + " different modes such as A00, B, C, A21",
                     std::to_string(names->size()) + " names, of which " + std::to_string(modes.size()) + " are modes");
  const NumberRange length{1e-3, kMaxMm, "mm"}, place{-kMaxMm, kMaxMm, "mm"};
  dsp::SurfaceModel<double> model;
  model.lx = required(surface, "lx_mm", length, "length scale Lx, mm");
  model.ly = required(surface, "ly_mm", length, "length scale Ly, mm");
  model.x0 = required(surface, "x0_mm", place, "model origin X0, mm");
  model.y0 = required(surface, "y0_mm", place, "model origin Y0, mm");
  if (!list) return std::nullopt;
  model.modes = *list;
  return model;
}

}  // namespace

Plates read_plates(TomlTable& table) {
  Plates plates;
  for (TomlTable& plate : table.tables("plate")) {
    if (!plate.has("thickness_mm")) plate.missing("thickness_mm", "the plate's thickness, mm");
    if (!plate.has("index")) plate.missing("index", "the plate's refractive index");
    plates.push_back({plate.number("thickness_mm", {0, kThickestMm, "mm"}).value_or(0),
                      plate.number("index", {1, kMaxIndex, ""}).value_or(1)});
  }
  if (plates.size() > dsp::kMaxLayers) {
    table.complain("plate", "at most " + std::to_string(dsp::kMaxLayers) + " plates", std::to_string(plates.size()));
    plates.resize(dsp::kMaxLayers);
  }
  return plates;
}

std::string plates_toml(std::string_view heading, const Plates& plates) {
  std::string text;
  for (const dsp::Layer<double>& plate : plates)
    text +=
        "[[" + std::string(heading) + "]]\nthickness_mm = " + real(plate.thickness) + "\nindex = " + real(plate.index) + "\n";
  return text;
}

Outcome<Plates> parse_plates(std::span<const std::string> texts, const std::string& option) {
  Plates plates;
  for (const std::string& text : texts) {
    const auto fields = split_commas(text);
    const auto thickness = fields.size() == 2 ? parse_number<double>(trimmed(fields[0])) : std::nullopt;
    const auto index = fields.size() == 2 ? parse_number<double>(trimmed(fields[1])) : std::nullopt;
    if (!thickness || !index || !(*thickness > 0 && *thickness <= kThickestMm) || !(*index >= 1 && *index <= kMaxIndex))
      return Problem{Exit::kUsage, option + " is no plate",
                     "",           "THICKNESS,INDEX: above 0 to 1000 mm, and 1 to 3",
                     text,         option + " 12,1.49 for 12 mm of acrylic"};
    plates.push_back({*thickness, *index});
  }
  if (plates.size() > dsp::kMaxLayers)
    return Problem{Exit::kUsage,
                   "too many plates",
                   option,
                   "at most " + std::to_string(dsp::kMaxLayers),
                   std::to_string(plates.size()),
                   ""};
  return plates;
}

Plates plates_of(const dsp::Media<double>& media) { return {media.layers.begin(), media.layers.begin() + media.n_layers}; }

void set_plates(dsp::Media<double>& media, const Plates& plates) {
  media.n_layers = static_cast<int>(std::min<std::size_t>(plates.size(), dsp::kMaxLayers));
  std::copy_n(plates.begin(), media.n_layers, media.layers.begin());
}

bool same_plates(const Plates& a, const Plates& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return x.thickness == y.thickness && x.index == y.index; });
}

std::string plates_text(const Plates& plates) {
  if (plates.empty()) return "no floor plates";
  std::string text;
  for (const dsp::Layer<double>& plate : plates)
    text += (text.empty() ? "floor plates " : ", ") + number_text(plate.thickness) + " mm of index " + number_text(plate.index);
  return text + " (from the top down)";
}

Outcome<std::optional<RecordedOptics>> read_recorded_optics(const fs::path& folder) {
  const fs::path file = folder / kOpticsName;
  std::error_code error;
  if (!fs::exists(file, error)) return std::optional<RecordedOptics>();
  const auto read = [&]() -> Outcome<RecordedOptics> {
    const auto toml = TomlFile::load(file);
    if (!toml) return toml.error();
    TomlTable root = toml->root();
    RecordedOptics optics;
    TomlTable water = root.table("water");
    optics.media.water = required(water, "refractive_index", {1, 2, ""}, "index of the water");
    set_plates(optics.media, read_plates(water));
    if (root.has("surface")) {
      TomlTable surface = root.table("surface");
      optics.model = read_model(surface);
    }
    if (auto done = toml->finish(); !done) return done.error();
    return optics;
  };
  auto optics = read();
  if (optics) return std::optional(*optics);
  Problem problem = optics.error();
  problem.exit = Exit::kInput;
  return problem;
}

Outcome<void> write_recorded_optics(const fs::path& folder, const RecordedOptics& optics) {
  std::string text = "# What the light went through when this was recorded, and the surface model. Plates from the top down.\n";
  text +=
      "[water]\nrefractive_index = " + real(optics.media.water) + "\n" + plates_toml("water.plate", plates_of(optics.media));
  if (optics.model) {
    text += "[surface]\nmodes = [\"" + joined(optics.model->modes, "\", \"") + "\"]\nlx_mm = " + real(optics.model->lx) +
            "\nly_mm = " + real(optics.model->ly) + "\nx0_mm = " + real(optics.model->x0) +
            "\ny0_mm = " + real(optics.model->y0) + "\n";
  }
  return write_text_file(folder / kOpticsName, text);
}

}  // namespace srd
