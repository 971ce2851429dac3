// SPDX-License-Identifier: Apache-2.0
#include "host/coefficients/model_file.hpp"

#include <system_error>
#include <utility>

#include "drivers/support/limits.hpp"
#include "drivers/support/mode_names.hpp"
#include "drivers/support/text_file.hpp"
#include "drivers/support/toml_reader.hpp"

namespace srd::host {
namespace {

// With a point, so that TOML keeps it a real number.
std::string number(double x) {
  std::string text = number_text(x);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      constexpr std::string_view kHex = "0123456789ABCDEF";
      const auto code = static_cast<unsigned char>(c);
      out += "\\u00";
      out += kHex[code >> 4U];
      out += kHex[code & 15U];
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::optional<dsp::ModeList> read_modes(TomlTable& table) {
  const auto names = table.texts("modes");
  if (!names) {
    if (!table.has("modes")) table.missing("modes", "a list of mode names, as [\"A00\", \"B\", \"C\"]");
    return std::nullopt;
  }
  std::vector<dsp::Mode> modes;
  for (const std::string& name : *names) {
    const auto mode = dsp::Mode::parse(name);
    if (!mode) {
      table.complain("modes", "names like A00, B, C, A21", "\"" + name + "\"");
      return std::nullopt;
    }
    modes.push_back(*mode);
  }
  const auto list = dsp::ModeList::make(modes);
  if (!list) {
    table.complain("modes", "1 to " + std::to_string(dsp::kMaxModes) + " different modes",
                   std::to_string(modes.size()) + " names, or one of them twice");
    return std::nullopt;
  }
  return *list;
}

double required(TomlTable& table, std::string_view key, const NumberRange& range, const std::string& meaning) {
  const auto value = table.number(key, range);
  if (!value && !table.has(key)) table.missing(key, meaning);
  return value.value_or(range.least);
}

std::optional<PatternExtent> read_extent(TomlTable& table) {
  const NumberRange range{-kMaxMm, kMaxMm, "mm"};
  const auto x = table.numbers("pattern_x", 2, range);
  const auto y = table.numbers("pattern_y", 2, range);
  if (table.has("pattern_x") != table.has("pattern_y"))
    table.missing(table.has("pattern_x") ? "pattern_y" : "pattern_x", "both of pattern_x and pattern_y, or none");
  if (x && (*x)[0] >= (*x)[1]) table.complain("pattern_x", "[least, most]", "least not below most");
  if (y && (*y)[0] >= (*y)[1]) table.complain("pattern_y", "[least, most]", "least not below most");
  if (!x || !y) return std::nullopt;
  return PatternExtent{(*x)[0], (*x)[1], (*y)[0], (*y)[1]};
}

Day read_day(TomlTable& table, std::string_view key) {
  const auto text = table.text(key);
  if (!text || text->empty()) return 0;
  const auto day = parse_day(*text);
  if (!day) table.complain(key, "a date as 2026-11-28, or \"\"", "\"" + *text + "\"");
  return day.value_or(0);
}

ErrorSources read_sources(TomlTable table) {
  ErrorSources sources;
  if (!table.has("pose")) table.missing("pose", "the pose's date, \"\" where it is not known");
  sources.pose = read_day(table, "pose");
  if (table.has("calibration")) sources.calibration = read_day(table, "calibration");
  return sources;
}

std::string date_of(Day day) { return day > 0 ? day_text(day) : ""; }

Outcome<ModelFile> read(const TomlFile& file) {
  ModelFile model_file;
  TomlTable root = file.root();
  std::vector<TomlTable> tables = root.tables("node");
  if (!root.has("node")) root.missing("node", "one [[node]] table a node");
  for (TomlTable& table : tables) {
    NodeModel node;
    const auto name = table.text("name");
    if (!name && !table.has("name")) table.missing("name", "the node's name as in the CSV file");
    node.node = name.value_or("");
    if (name && model_file.find(*name) != nullptr) table.complain("name", "every node once", "\"" + *name + "\" twice");
    node.model.modes = read_modes(table).value_or(dsp::ModeList{});
    const NumberRange length{1e-3, kMaxMm, "mm"}, place{-kMaxMm, kMaxMm, "mm"};
    node.model.lx = required(table, "lx", length, "length scale Lx, mm");
    node.model.ly = required(table, "ly", length, "length scale Ly, mm");
    node.model.x0 = required(table, "x0", place, "model origin X0, mm");
    node.model.y0 = required(table, "y0", place, "model origin Y0, mm");
    node.refractive_index = required(table, "refractive_index", {1.0, 4.0, ""}, "index of the water");
    node.pattern = read_extent(table);
    node.plates = read_plates(table);
    if (table.has("systematic")) node.systematic = read_sources(table.table("systematic"));
    model_file.nodes.push_back(std::move(node));
  }
  if (auto done = file.finish(); !done) return done.error();
  return model_file;
}

}  // namespace

const NodeModel* ModelFile::find(std::string_view node) const {
  for (const NodeModel& candidate : nodes)
    if (candidate.node == node) return &candidate;
  return nullptr;
}

std::string sources_text(const ErrorSources& sources) {
  const auto of = [](const char* what, Day day) {
    return std::string(what) + (day > 0 ? " of " + day_text(day) : " (of an unknown date)");
  };
  return of("the pose", sources.pose) + (sources.calibration ? " and " + of("the calibration", *sources.calibration)
                                                             : std::string("; the calibration counts as exact"));
}

std::filesystem::path model_file_path(const std::filesystem::path& csv) {
  std::filesystem::path path = csv;
  path += ".model.toml";
  return path;
}

Outcome<ModelFile> read_model_file(const std::filesystem::path& file) {
  const auto toml = TomlFile::load(file);
  if (!toml) return toml.error();
  return read(*toml);
}

Outcome<ModelFile> parse_model_file(std::string_view text, const std::string& name) {
  const auto toml = TomlFile::parse(text, name);
  if (!toml) return toml.error();
  return read(*toml);
}

std::string model_file_text(const ModelFile& model_file) {
  std::string out = "# The surface model behind the coefficients of the CSV file beside this one. Lengths in mm.\n";
  for (const NodeModel& node : model_file.nodes) {
    out += "\n[[node]]\nname = " + in_quotes(node.node) + "\nmodes = [\"" + joined(node.model.modes, "\", \"") + "\"]\n";
    out += "lx = " + number(node.model.lx) + "\nly = " + number(node.model.ly) + "\n";
    out += "x0 = " + number(node.model.x0) + "\ny0 = " + number(node.model.y0) + "\n";
    out += "refractive_index = " + number(node.refractive_index) + "\n";
    if (node.pattern) {
      out += "pattern_x = [" + number(node.pattern->x_min) + ", " + number(node.pattern->x_max) + "]\n";
      out += "pattern_y = [" + number(node.pattern->y_min) + ", " + number(node.pattern->y_max) + "]\n";
    }
    out += plates_toml("node.plate", node.plates);
    if (node.systematic) {
      out += "[node.systematic]\npose = \"" + date_of(node.systematic->pose) + "\"\n";
      if (node.systematic->calibration) out += "calibration = \"" + date_of(*node.systematic->calibration) + "\"\n";
    }
  }
  return out;
}

Outcome<void> write_model_file(const std::filesystem::path& file, const ModelFile& model_file) {
  std::filesystem::path half = file;
  half += ".part";
  if (auto written = write_text_file(half, model_file_text(model_file)); !written) return written.error();
  std::error_code error;
  std::filesystem::rename(half, file, error);
  if (error)
    return Problem{Exit::kInput, "cannot be written", file.string(), "a file that may be replaced", error.message(), ""};
  return {};
}

}  // namespace srd::host
