// SPDX-License-Identifier: Apache-2.0
#include "host/study/command.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "host/study/study.hpp"

namespace srd::host {
namespace {

Outcome<void> run_study(study::StudyOptions& options) {
  if (options.out.empty()) return Problem{Exit::kUsage, "no folder to write to", "srd study", "--out DIR", "", "add --out DIR"};
  if (isatty(STDERR_FILENO) != 0)
    options.progress = [](int done, int all) {
      std::cerr << "\rcondition " << done << " of " << all << (done == all ? "\n" : "") << std::flush;
    };
  const auto files = study::study(options);
  if (!files) return files.error();
  for (const auto& file : *files) std::cout << file.string() << "\n";
  std::cout << std::flush;
  return {};
}

}  // namespace

void add_study_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<study::StudyOptions>();
  CLI::App* command =
      app.add_subcommand("study", "Measure the accuracy of corners and surfaces on rendered images with known truth");
  command->add_option("--out", options->out, "Folder for study.html, figures and tables");
  command->add_flag("--quick", options->quick, "Few conditions and draws: seconds in place of a minute");
  command->add_flag("--force", options->force, "Replace files that are there");
  command->callback([options, &exit_code] {
    const Outcome<void> done = run_study(*options);
    if (!done) std::cerr << done.error().text();
    exit_code = static_cast<int>(done ? Exit::kDone : done.error().exit);
  });
}

}  // namespace srd::host
