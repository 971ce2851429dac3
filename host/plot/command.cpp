// SPDX-License-Identifier: Apache-2.0
#include "host/plot/command.hpp"

#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "host/plot/report.hpp"

namespace srd::host {

void add_plot_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<PlotOptions>();
  CLI::App* command = app.add_subcommand("plot", "Draw coefficients as PNG figures and one HTML page");
  command->add_option("FILE.csv", options->file, "Coefficients written by srd listen or srd reconstruct")->required();
  command->add_option("--truth", options->truth, "True coefficients to draw and compare with: frame,time_ns,<modes>");
  command->add_flag("--by-order", options->by_order, "Match the truth's first row with the first, not by time_ns");
  command->add_option("--out", options->out, "Folder for the files (default: the one of FILE.csv)");
  command->add_option("--node", options->node, "Which node, when the file holds several");
  command->add_option("--frame", options->frame, "Sequence of the frame whose surface is drawn (default: the last)");
  command->add_flag("--force", options->force, "Replace files that are there");
  add_geometry_options(*command, options->geometry);
  command->callback([options, &exit_code] {
    const auto files = plot(*options);
    if (!files) {
      std::cerr << files.error().text();
      exit_code = static_cast<int>(files.error().exit);
      return;
    }
    for (const std::string& note : files->notes) std::cerr << "note: " << note << "\n";
    for (const auto& file : files->written) std::cout << file.string() << "\n";
    std::cout << std::flush;
    exit_code = static_cast<int>(Exit::kDone);
  });
}

}  // namespace srd::host
