// SPDX-License-Identifier: Apache-2.0
#include "host/pose/command.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <memory>

#include "drivers/recording/recorded_optics.hpp"
#include "drivers/support/text_file.hpp"
#include "host/pose/pose_files.hpp"
#include "host/run/option_checks.hpp"

namespace srd::host {

namespace {

constexpr double kDefaultDepth = 100;  // mm

struct PoseOptions {
  std::vector<std::filesystem::path> references;
  std::filesystem::path calibration, out;
  PatternOptions pattern;
  std::optional<double> level, level_deviation;
  MediaOptions media;
  std::vector<std::string> modes = {"A00", "B", "C"};
  std::vector<double> depths;
  std::optional<double> lx, ly;
  std::vector<std::filesystem::path> views;
  double print_mm = 0.1;
  bool force = false;
};

Problem pose_usage(const std::string& what, const std::string& expected, const std::string& found, const std::string& advice) {
  return {Exit::kUsage, what, "srd pose", expected, found, advice};
}

Outcome<dsp::ModeList> pose_modes(const std::vector<std::string>& names) {
  std::vector<dsp::Mode> modes;
  std::string given;
  bool known = true;
  for (const std::string& name : names) {
    given += (given.empty() ? "" : ",") + name;
    const auto mode = dsp::Mode::parse(name);
    known = known && mode.has_value();
    if (mode) modes.push_back(*mode);
  }
  const auto list = dsp::ModeList::make(modes);
  if (!known || !list)
    return pose_usage("--modes", "1 to 24 different modes of A00, B, C and Amn with one digit each", given, "");
  return *list;
}

Outcome<void> run_pose(const PoseOptions& options) {
  PoseRequest request;
  request.references = options.references;
  request.calibration = options.calibration;
  if (auto taken = take_pattern_options(options.pattern, request); !taken) return taken;
  const auto media = media_of(options.media);
  if (!media) return media.error();
  request.water.media = *media;
  request.water.level_mm = options.level;
  request.water.level_deviation_mm = options.level_deviation.value_or(0);
  if (options.level_deviation && !options.level)
    return pose_usage("--level-deviation without --water-level", "both, for a reference through still water", "a dry reference",
                      "add --water-level MM");
  if (options.level && !options.level_deviation)
    return pose_usage("--water-level without --level-deviation", "the standard deviation of the measured level, mm", "none",
                      "add --level-deviation MM: what the gauge reads to, and its zero against the pattern");
  if (options.level && !(*options.level > request.water.media.plates()))
    return pose_usage("--water-level lies in the floor plates",
                      "a level above the pattern of more than the plates' " + number_text(request.water.media.plates()) + " mm",
                      number_text(*options.level) + " mm", "levels count from the pattern, not from the plates");
  HeightRequest heights;
  heights.depths_mm = options.depths;
  if (heights.depths_mm.empty()) heights.depths_mm = {options.level.value_or(kDefaultDepth + request.water.media.plates())};
  const auto modes = pose_modes(options.modes);
  if (!modes) return modes.error();
  heights.modes = *modes;
  heights.lx_mm = options.lx;
  heights.ly_mm = options.ly;
  std::error_code error;
  for (const auto& file : pose_files(options.out))
    if (!options.force && std::filesystem::exists(file, error))
      return Problem{
          Exit::kUsage, "the file is there already", file.string(), "", "", "another --out DIR, or --force to replace it"};

  auto pose = measure_pose(request);
  if (!pose) return pose.error();
  PoseResult result;
  result.pose = std::move(pose).value();
  result.listed = result.pose.points;
  if (!options.views.empty()) {
    if (options.level)
      return pose_usage("--view with --water-level", "dry views, all of them", "a reference through water", "");
    auto print = refine_points(result.pose, options.views, request, options.print_mm);
    if (!print) return print.error();
    if (auto fitted = fit_again(result.pose, print->points, request.water, options.references.front().string()); !fitted)
      return fitted;
    result.print = std::move(print).value();
  }
  result.water = request.water;
  result.calibration_file = options.calibration.string();
  for (const auto& reference : options.references) result.references.push_back(reference.string());
  auto effects = height_effects(result.pose, request.water.media, heights);
  if (!effects) return effects.error();
  result.effects = std::move(effects).value();
  if (auto written = write_pose_files(result, options.out); !written) return written;
  for (const std::string& warning : result.pose.warnings) std::cerr << "warning: " << warning << "\n";
  std::cout << pose_summary(result) << "results in " << options.out.string() << "\n" << std::flush;
  return {};
}

}  // namespace

void add_pattern_options(CLI::App& command, PatternOptions& values) {
  command.add_option("--pattern", values.points, "Points of the pattern's corners: x y z (mm) a line, row by row");
  command.add_option("--board", values.board,
                     "ROWSxCOLUMNS of inner corners instead: rows along X (down the image), columns along Y (to the right)");
  command.add_option("--square-mm", values.square_mm, "With --board: side of a square, mm")->check(within(0, 1e4, "mm"));
  command
      .add_option("--position", values.position,
                  "Camera position 1 to 4 of OpenSRD's guide, appendix A: 2 and 3 see the pattern from its end (default: found "
                  "from the pattern)")
      ->check(CLI::Range(1, 4));
  command.add_option("--first-corner", values.position_corner, "U,V: about where the pattern's first point is seen, px");
  const std::vector<std::pair<std::string, OriginSquare>> squares = {
      {"dark", OriginSquare::kDark}, {"bright", OriginSquare::kBright}, {"unknown", OriginSquare::kUnknown}};
  takes_one_of(
      command.add_option("--origin-square", values.origin, "Colour of the world's first square: dark, bright or unknown"),
      squares)
      ->default_str("dark");
  takes_one_of(command.add_option("--radius", values.search.radius, "Of the corner response, px: 5 or 10"), {5, 10})
      ->default_str("5");
  command.add_option("--threshold", values.search.threshold, "Least corner response")->check(CLI::Range(1, 4000));
  command.add_option("--min-distance", values.search.min_distance, "Between two corners, px")->check(within(0, 1000, "px"));
}

Outcome<void> take_pattern_options(const PatternOptions& values, PoseRequest& request) {
  const auto usage = [](const std::string& what, const std::string& expected, const std::string& found) {
    return Problem{Exit::kUsage, what, "", expected, found, ""};
  };
  if (!values.points.empty()) request.points_file = values.points;
  request.square_mm = values.square_mm;
  request.search = values.search;
  if (!values.board.empty()) {
    const auto cross = values.board.find_first_of("xX");
    std::optional<int> rows, columns;
    if (cross != std::string::npos) {
      rows = parse_number<int>(std::string_view(values.board).substr(0, cross));
      columns = parse_number<int>(std::string_view(values.board).substr(cross + 1));
    }
    if (!rows || !columns || *rows < 2 || *columns < 2 || *rows > 500 || *columns > 500)
      return usage("--board", "ROWSxCOLUMNS of inner corners, 2 to 500 each: 17x7", "'" + values.board + "'");
    request.board = PatternSize{*rows, *columns};
  }
  request.order.position = values.position;
  if (!values.position_corner.empty()) {
    const auto fields = split_commas(values.position_corner);
    std::optional<double> u, v;
    if (fields.size() == 2) u = parse_number<double>(fields[0]), v = parse_number<double>(fields[1]);
    if (!u || !v) return usage("--first-corner", "U,V: two numbers, px", "'" + values.position_corner + "'");
    if (values.position != 0) return usage("--first-corner and --position exclude each other", "one of them", "both");
    request.order.first_corner = dsp::Vec2<double>(*u, *v);
  }
  request.order.origin = values.origin;
  return {};
}

void add_media_options(CLI::App& command, MediaOptions& values) {
  command.add_option("--refractive-index", values.index, "Of the water, against air 1 (default 1.333)")
      ->check(within(1, 2, ""));
  command
      .add_option("--plate", values.plates,
                  "THICKNESS,INDEX of a transparent plate on the pattern, mm; again for each further one, from the top down")
      ->expected(1)
      ->take_all();
}

Outcome<dsp::Media<double>> media_of(const MediaOptions& values) {
  const auto plates = parse_plates(values.plates, "--plate");
  if (!plates) return plates.error();
  dsp::Media<double> media;
  media.water = values.index.value_or(media.water);
  set_plates(media, *plates);
  return media;
}

void add_pose_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<PoseOptions>();
  CLI::App* command = app.add_subcommand("pose", "Find where a camera is, from images of the pattern, with its errors");
  command->add_option("REFERENCE", options->references, "Image of the dry pattern; several, or a folder: their mean")
      ->required();
  command->add_option("--calibration", options->calibration, "The camera's calibration.yml")->required();
  command->add_option("--out", options->out, "Folder for the results; made when it is not there")->required();
  command->add_flag("--force", options->force, "Replace results that are there already");
  add_pattern_options(*command, options->pattern);
  const char* wet = "Through still water";
  command->add_option("--water-level", options->level, "Of still water over the pattern, mm; without it the reference is dry")
      ->check(within(0, 1e5, "mm"))
      ->group(wet);
  command->add_option("--level-deviation", options->level_deviation, "Standard deviation of that level, mm")
      ->check(CLI::NonNegativeNumber)
      ->check(within(-1, 1e3, "mm"))
      ->group(wet);
  add_media_options(*command, options->media);
  const char* print = "The pattern's own points";
  command
      ->add_option("--view", options->views,
                   "Dry images of the pattern from other places, same lens: its points are found with them (2 or more)")
      ->group(print);
  command->add_option("--print-mm", options->print_mm, "How far the print may be off, one standard deviation, mm")
      ->capture_default_str()
      ->check(within(0, 100, "mm"))
      ->group(print);
  const char* effect = "What the errors mean for surfaces";
  command
      ->add_option("--depth", options->depths,
                   "Still water above the pattern to tell it for, mm; several with commas "
                   "(default: the level, else 100)")
      ->delimiter(',')
      ->check(within(0, 1e5, "mm"))
      ->group(effect);
  command->add_option("--modes", options->modes, "Modes of the surface (default A00,B,C)")->delimiter(',')->group(effect);
  command->add_option("--lx", options->lx, "Length scale along X, mm (default: the pattern's)")
      ->check(within(0, 1e6, "mm"))
      ->group(effect);
  command->add_option("--ly", options->ly, "Length scale along Y, mm (default: the pattern's)")
      ->check(within(0, 1e6, "mm"))
      ->group(effect);
  command->callback([options, &exit_code] {
    const auto done = run_pose(*options);
    if (!done) std::cerr << done.error().text();
    exit_code = static_cast<int>(done ? Exit::kDone : done.error().exit);
  });
}

}  // namespace srd::host
