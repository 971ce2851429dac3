// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/node_config.hpp"

#include <cmath>

#include "drivers/support/modes_key.hpp"
#include "drivers/support/toml_reader.hpp"
#include "dsp/optics/refractive_index.hpp"
#include "proto/identity.hpp"
#include "proto/plain_word.hpp"

namespace srd::firmware {

namespace {

constexpr double kLargest = 1e5;  // mm

template <class T, class U>
void set(T& to, const std::optional<U>& from) {
  if (from) to = static_cast<T>(*from);
}

void read_node(TomlTable node, const std::filesystem::path& folder, NodeConfig& config) {
  if (auto id = node.text("id")) {
    if (!proto::NodeId::make(*id))
      node.complain("id", "1 to 31 letters, digits, '-', '_' and '.'", "\"" + *id + "\"");
    else if (proto::reads_as_value(*id))
      node.complain("id", "a name that no program reads as a number, a date, a truth value or a missing one", "\"" + *id + "\"",
                    "a word before it: \"flume-" + *id + "\"");
    else
      config.node_id = *id;
  }
  set(config.host, node.text("host"));
  if (auto key = node.text("key")) config.key = folder / *key;
  set(config.ring_frames, node.integer("ring_frames", {16, 1e6, "frames"}));
  if (auto state = node.text("state")) config.state = folder / *state;
}

void read_transmit(TomlTable transmit, const std::filesystem::path& folder, NodeConfig& config) {
  auto spill = transmit.text("spill");
  if (!spill) return;
  if (spill->empty())
    transmit.complain("spill", "a folder", "\"\"", "leave the key out to keep frames in memory alone");
  else
    config.spill = folder / *spill;
}

void read_geometry(TomlTable geometry, NodeConfig& config) {
  set(config.calibration, geometry.text("calibration"));
  set(config.pose, geometry.text("pose"));
  set(config.points, geometry.text("points"));
}

void read_pattern(TomlTable pattern, NodeConfig& config) {
  if (auto first = pattern.choice("first_square", {"dark", "bright", "unknown"}))
    config.first_square = *first == "dark"     ? dsp::FirstSquare::kDark
                          : *first == "bright" ? dsp::FirstSquare::kBright
                                               : dsp::FirstSquare::kUnknown;
  const bool any =
      pattern.has("rows") || pattern.has("columns") || pattern.has("square_mm") || pattern.has("x0_mm") || pattern.has("y0_mm");
  PatternGrid grid;
  set(grid.rows, pattern.integer("rows", {2, 1000, "corners along X"}));
  set(grid.columns, pattern.integer("columns", {2, 1000, "corners along Y"}));
  set(grid.square_mm, pattern.number("square_mm", {0.01, 10000, "mm"}));
  set(grid.x0_mm, pattern.number("x0_mm", {-kLargest, kLargest, "mm"}));
  set(grid.y0_mm, pattern.number("y0_mm", {-kLargest, kLargest, "mm"}));
  if (!any) return;
  if (!pattern.has("rows")) pattern.missing("rows", "the number of corners along X");
  if (!pattern.has("columns")) pattern.missing("columns", "the number of corners along Y");
  if (!pattern.has("square_mm")) pattern.missing("square_mm", "the side of a square, mm");
  config.pattern = grid;
  if (!config.points.empty())
    pattern.complain("rows", "either a grid here or geometry.points", "both", "leave one of them out");
}

void read_water(TomlTable water, NodeConfig& config) {
  set(config.refractive_index, water.number("refractive_index", {1.0001, 2}));
  const auto temperature =
      water.number("water_temperature_c", {dsp::kWaterTemperatureC.least, dsp::kWaterTemperatureC.most, "degrees C"});
  const auto salinity =
      water.number("salinity_per_mille", {dsp::kWaterSalinityPerMille.least, dsp::kWaterSalinityPerMille.most, "per mille"});
  const auto wavelength = water.number("wavelength_nm", {dsp::kWaterWavelengthNm.least, dsp::kWaterWavelengthNm.most, "nm"});
  if (temperature || salinity || wavelength) {
    if (config.refractive_index)
      water.complain("refractive_index", "either the index or temperature, salinity and wavelength", "both",
                     "leave one of them out");
    if (const auto index =
            dsp::water_refractive_index(temperature.value_or(20), salinity.value_or(0), wavelength.value_or(589)))
      config.refractive_index = *index;
  }
  if (water.has("plate")) config.plates = read_plates(water);
}

void read_surface(TomlTable surface, NodeConfig& config) {
  // Five where it does not say.
  config.modes = read_modes(surface).value_or(*dsp::ModeList::standard(5));
  set(config.lx_mm, surface.number("lx_mm", {0.001, kLargest, "mm"}));
  set(config.ly_mm, surface.number("ly_mm", {0.001, kLargest, "mm"}));
  set(config.x0_mm, surface.number("x0_mm", {-kLargest, kLargest, "mm"}));
  set(config.y0_mm, surface.number("y0_mm", {-kLargest, kLargest, "mm"}));
  const std::size_t n = static_cast<std::size_t>(config.modes.size());
  const NumberRange height{-kLargest, kLargest, "mm"};
  if (auto guess = surface.numbers("guess_mm", 0, height)) {
    if (n > 0 && (guess->empty() || guess->size() > n))  // wrong modes were complained of
      surface.complain("guess_mm", "1 to " + std::to_string(n) + " numbers, one a mode", std::to_string(guess->size()));
    else
      config.guess = *guess;
  } else if (!surface.has("guess_mm")) {
    surface.missing("guess_mm", "the level to start from, mm, such as [80.0]");
  }
  config.guess.resize(n, 0);
  set(config.estimator.lower, surface.numbers("lower_mm", n, height));
  set(config.estimator.upper, surface.numbers("upper_mm", n, height));
  set(config.estimator.scale, surface.numbers("scale", n, {1e-9, 1e9}));
  for (std::size_t i = 0; i < n && i < config.estimator.lower.size() && i < config.estimator.upper.size(); ++i)
    if (config.estimator.lower[i] > config.estimator.upper[i])
      surface.complain("lower_mm", "no number above its upper_mm", std::to_string(config.estimator.lower[i]));
}

void read_detector(TomlTable detector, NodeConfig& config) {
  dsp::DetectorOptions& d = config.tracker.detector;
  set(d.response.radius, detector.integer("radius_px", {5, 10}));
  if (d.response.radius != 5 && d.response.radius != 10)
    detector.complain("radius_px", "5 or 10", std::to_string(d.response.radius));
  set(d.response.mean_term, detector.boolean("mean_term"));
  set(d.threshold, detector.integer("threshold", {1, 2040}));
  set(d.min_distance, detector.integer("min_distance_px", {1, 200, "px"}));
  set(d.fit.half_window, detector.integer("half_window_px", {3, 8, "px"}));
  set(d.fit.min_contrast, detector.integer("min_contrast", {1, 127, "grey levels, half of bright less dark"}));
  if (auto region = detector.numbers("region_px", 4, {0, 65535, "px"})) {
    const auto px = [&](std::size_t i) { return static_cast<int>((*region)[i]); };
    config.region = {px(0), px(1), px(2), px(3)};
    if (config.region.empty()) detector.complain("region_px", "[u0, v0, u1, v1] with u0 < u1 and v0 < v1", "an empty region");
  }
}

void read_tracker(TomlTable tracker, NodeConfig& config) {
  dsp::SurfaceTrackerOptions& t = config.tracker;
  set(t.search_radius, tracker.integer("search_radius_px", {1, 15, "px"}));
  set(t.min_corners, tracker.integer("min_corners", {1, 10000}));
  set(t.max_rms_px, tracker.number("max_rms_px", {0.001, 100, "px"}));
  set(t.max_deviation_mm, tracker.number("max_deviation_mm", {0, 1e6, "mm"}));
  set(t.outlier_factor, tracker.number("outlier_factor", {0, 1000}));
  set(t.sigma_floor_px, tracker.number("sigma_floor_px", {0, 100, "px"}));
  set(t.weigh_corners, tracker.boolean("weigh_corners"));
}

void read_estimator(TomlTable estimator, NodeConfig& config) {
  dsp::EstimatorOptions& e = config.estimator;
  std::vector<std::string> metrics;
  for (const dsp::Metric metric : dsp::kMetrics) metrics.emplace_back(to_string(metric));
  if (const auto metric = estimator.choice("metric", metrics)) e.metric = *dsp::parse_metric(*metric);
  if (auto loss = estimator.choice("loss", {"none", "huber", "tukey"}))
    e.loss = *loss == "huber" ? dsp::Loss::kHuber : *loss == "tukey" ? dsp::Loss::kTukey : dsp::Loss::kNone;
  // Each rule by itself: a key that is given leaves the others as they are.
  e.epsg = estimator.number("epsg", {0, 1}).value_or(e.kDefaultEpsg);
  e.epsf = estimator.number("epsf", {0, 1}).value_or(e.kDefaultEpsf);
  e.epsx = estimator.number("epsx", {0, 1}).value_or(e.kDefaultEpsx);
  e.max_iterations = static_cast<int>(estimator.integer("max_iterations", {0, 1000}).value_or(e.kDefaultMaxIterations));
  config.deadline_us = estimator.integer("deadline_us", {1, 1e9, "us"});
}

}  // namespace

Outcome<NodeConfig> NodeConfig::load(const std::filesystem::path& file) {
  Outcome<TomlFile> toml = TomlFile::load(file);
  if (!toml) return toml.error();
  return read(*toml, file);
}

Outcome<NodeConfig> NodeConfig::parse(std::string_view text, const std::filesystem::path& file) {
  Outcome<TomlFile> toml = TomlFile::parse(text, file.string());
  if (!toml) return toml.error();
  return read(*toml, file);
}

Outcome<NodeConfig> NodeConfig::read(const TomlFile& toml, const std::filesystem::path& file) {
  NodeConfig config;
  config.file = file;
  TomlTable root = toml.root();
  read_node(root.table("node"), file.parent_path(), config);
  read_transmit(root.table("transmit"), file.parent_path(), config);
  read_camera(root.table("camera"), file.parent_path(), config);
  config.strobe = read_strobe(root.table("strobe"), {config.frame_rate_hz, config.live.exposure_us, config.live.shutter,
                                                     config.live.readout_us, config.live.trigger_input});
  read_geometry(root.table("geometry"), config);
  read_pattern(root.table("pattern"), config);
  read_water(root.table("water"), config);
  read_surface(root.table("surface"), config);
  read_detector(root.table("detector"), config);
  read_tracker(root.table("tracker"), config);
  read_estimator(root.table("estimator"), config);
  config.realtime = read_realtime(root);
  config.recording = read_recording_section(root.table("record"), file.parent_path());
  if (auto done = toml.finish(); !done) return done.error();
  return config;
}

}  // namespace srd::firmware
