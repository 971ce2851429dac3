// SPDX-License-Identifier: Apache-2.0
#include "host/simulate/command.hpp"

#include <unistd.h>

#include <iostream>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "drivers/support/text_file.hpp"
#include "host/simulate/simulation.hpp"

namespace srd::host {
namespace {

struct SimulateOptions {
  std::string scene_file;
  SimulationOptions simulation;
  std::optional<int> frames;
  std::optional<std::int64_t> seed;
  bool default_scene = false;
  bool pgm = false;
};

Outcome<void> run_simulate(SimulateOptions& options) {
  if (options.default_scene) {
    std::cout << default_scene_text() << std::flush;
    return {};
  }
  if (options.simulation.out.empty())
    return Problem{Exit::kUsage, "no folder to write to", "srd simulate", "--out DIR", "", "add --out DIR"};
  std::string text{default_scene_text()};
  if (!options.scene_file.empty()) {
    Outcome<std::string> given = read_text_file(options.scene_file, "a scene file", std::size_t{1} << 24);
    if (!given) {
      given.error().exit = Exit::kUsage;
      return given.error();
    }
    text = *given;
  }
  Outcome<Scene> scene = parse_scene(text, options.scene_file.empty() ? "built-in scene" : options.scene_file);
  if (!scene) return scene.error();
  if (options.frames) scene->frames = *options.frames;
  if (options.seed) scene->seed = static_cast<std::uint64_t>(*options.seed);
  options.simulation.format = options.pgm ? ImageFormat::kPgm : ImageFormat::kPng;
  if (isatty(STDERR_FILENO) != 0)
    options.simulation.progress = [](int done, int all) {
      std::cerr << "\rframe " << done << " of " << all << (done == all ? "\n" : "") << std::flush;
    };
  if (Outcome<void> written = write_simulation(*scene, text, options.simulation); !written) return written;
  std::cout << options.simulation.out.string() << ": " << scene->frames << " frames of " << scene->width() << " x "
            << scene->height() << " px\n"
            << std::flush;
  return {};
}

}  // namespace

void add_simulate_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* command = app.add_subcommand("simulate", "Render a recording of moving water with known truth");
  command->add_option("SCENE.toml", options->scene_file, "The scene; the built-in flume when left out");
  command->add_option("--out", options->simulation.out, "Folder for the recording");
  command->add_option("--frames", options->frames, "Number of frames, in place of the scene's")->check(CLI::Range(1, 1000000));
  command->add_option("--seed", options->seed, "Seed of the noise, in place of the scene's")->check(CLI::NonNegativeNumber);
  command->add_flag("--pgm", options->pgm, "Images as PGM (larger, faster to read) in place of PNG");
  command->add_flag("--force", options->simulation.force, "Replace a recording that is there");
  command->add_flag("--default-scene", options->default_scene, "Print the built-in scene as a commented file and end");
  command->callback([options, &exit_code] {
    const Outcome<void> done = run_simulate(*options);
    if (!done) std::cerr << done.error().text();
    exit_code = static_cast<int>(done ? Exit::kDone : done.error().exit);
  });
}

}  // namespace srd::host
