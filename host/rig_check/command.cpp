// SPDX-License-Identifier: Apache-2.0
#include "host/rig_check/command.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "drivers/support/text_file.hpp"
#include "host/pose/command.hpp"
#include "host/rig_check/rig_check.hpp"
#include "host/run/option_checks.hpp"

namespace srd::host {

namespace {

struct LevelOptions {
  std::optional<double> level, deviation;
};

struct RigOptions {
  std::filesystem::path reference, later, calibration, report;
  PatternOptions pattern;
  LevelOptions before, after;
  MediaOptions media;
  double false_alarm = 1e-6, least_px = 0.02;
  bool force = false;
};

Outcome<void> take_level(const LevelOptions& given, const std::string& name, StillWater& water) {
  if (given.level.has_value() != given.deviation.has_value())
    return Problem{Exit::kUsage,    "--" + name + "-level and --" + name + "-level-deviation belong together",
                   "srd rig-check", "both, through still water, or neither",
                   "one of them",   ""};
  if (given.level && !(*given.level > water.media.plates()))
    return Problem{Exit::kUsage,
                   "--" + name + "-level lies in the floor plates",
                   "srd rig-check",
                   "more than the plates' " + number_text(water.media.plates()) + " mm",
                   number_text(*given.level) + " mm",
                   "levels count from the pattern"};
  water.level_mm = given.level;
  water.level_deviation_mm = given.deviation.value_or(0);
  return {};
}

Outcome<bool> run_rig_check(const RigOptions& options) {
  RigRequest request;
  request.reference.references = {options.reference};
  request.reference.calibration = options.calibration;
  request.later = {options.later};
  request.false_alarm = options.false_alarm;
  request.least_px = options.least_px;
  if (auto taken = take_pattern_options(options.pattern, request.reference); !taken) return taken.error();
  const auto media = media_of(options.media);
  if (!media) return media.error();
  request.reference.water.media = request.later_water.media = *media;
  if (auto taken = take_level(options.before, "reference", request.reference.water); !taken) return taken.error();
  if (auto taken = take_level(options.after, "later", request.later_water); !taken) return taken.error();
  std::error_code error;
  if (!options.report.empty() && !options.force && std::filesystem::exists(options.report, error))
    return Problem{Exit::kUsage,
                   "the file is there already",
                   options.report.string(),
                   "",
                   "",
                   "another --report, or --force to replace it"};
  const auto found = check_rig(request);
  if (!found) return found.error();
  if (!options.report.empty())
    if (auto written = write_text_file(options.report, rig_toml(*found, request)); !written) return written.error();
  for (const std::string& warning : found->warnings) std::cerr << "warning: " << warning << "\n";
  std::cout << rig_text(*found, request) << std::flush;
  return found->moved;
}

}  // namespace

void add_rig_check_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RigOptions>();
  CLI::App* command =
      app.add_subcommand("rig-check", "Tell whether the camera or the pattern has moved: exit code 0 unmoved, 6 moved");
  command->add_option("REFERENCE", options->reference, "Image of the pattern, or a folder of them, that the pose comes from")
      ->required();
  command->add_option("LATER", options->later, "Image of the same pattern now, or a folder of them")->required();
  command->add_option("--calibration", options->calibration, "The camera's calibration.yml")->required();
  add_pattern_options(*command, options->pattern);
  const auto level = [&](const std::string& name, LevelOptions& values) {
    command
        ->add_option("--" + name + "-level", values.level, "Of still water over the pattern in that image, mm (default: dry)")
        ->check(within(0, 1e5, "mm"));
    command->add_option("--" + name + "-level-deviation", values.deviation, "Standard deviation of that level, mm")
        ->check(within(-1e-300, 1e3, "mm"));
  };
  level("reference", options->before);
  level("later", options->after);
  add_media_options(*command, options->media);
  command->add_option("--false-alarm", options->false_alarm, "How often an unmoved rig may be told as moved")
      ->capture_default_str()
      ->check(within(0, 0.5, ""));
  command
      ->add_option("--least-px", options->least_px,
                   "Moves that shift every corner by less are not told, px: the detector's own limits")
      ->capture_default_str()
      ->check(within(-1e-300, 100, "px"));
  command->add_option("--report", options->report, "Write the numbers to this TOML file");
  command->add_flag("--force", options->force, "Replace a report that is there already");
  command->callback([options, &exit_code] {
    const auto moved = run_rig_check(*options);
    if (!moved) std::cerr << moved.error().text();
    exit_code = !moved ? static_cast<int>(moved.error().exit) : *moved ? kMovedExit : static_cast<int>(Exit::kDone);
  });
}

}  // namespace srd::host
