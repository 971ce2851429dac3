// SPDX-License-Identifier: Apache-2.0
#include "host/compare/command.hpp"

#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "host/compare/comparison.hpp"

namespace srd::host {
namespace {

struct Options {
  std::filesystem::path estimated, truth;
  std::string node;
  bool by_order = false;
  std::optional<double> max_rms;  // mm
  GeometryOptions geometry;
};

Outcome<void> run_compare(const Options& options) {
  const auto run = read_coefficient_run(options.estimated, options.node);
  if (!run) return run.error();
  if (auto usable = require_surface(*run); !usable) return usable.error();
  const auto truth = read_truth(options.truth);
  if (!truth) return truth.error();
  const auto geometry = resolve_geometry(*run, options.geometry);
  if (!geometry) return geometry.error();
  if (options.max_rms && !*geometry)
    return Problem{Exit::kUsage, "--max-rms needs the surface over the pattern",
                   run->file,    "a model file beside the CSV file, or --model",
                   "none",       ""};
  const auto comparison =
      compare(*run, *truth, options.truth.string(), options.by_order ? MatchBy::kOrder : MatchBy::kTime, *geometry);
  if (!comparison) return comparison.error();
  for (const std::string& note : run->notes) std::cerr << "note: " << note << "\n";
  std::cout << comparison_text(*run, *truth, *comparison, *geometry) << std::flush;
  if (options.max_rms && !(comparison->surface_rms <= *options.max_rms))
    return Problem{.what = "the surface is too far from the truth",
                   .where = run->file,
                   .expected = "rms over the pattern of at most " + std::to_string(*options.max_rms) + " mm",
                   .found = std::to_string(comparison->surface_rms) + " mm"};
  return {};
}

}  // namespace

void add_compare_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("compare", "Print how far estimated surfaces are from the true ones");
  command->add_option("ESTIMATED.csv", options->estimated, "Coefficients written by srd listen or srd reconstruct")->required();
  command->add_option("TRUTH.csv", options->truth, "True surfaces: frame,time_ns,<modes>")->required();
  command->add_option("--node", options->node, "Which node, when the file holds several");
  command->add_flag("--by-order", options->by_order, "Match the first row with the first, not by time_ns");
  command->add_option("--max-rms", options->max_rms, "Exit with 3 when the surface's rms over the pattern is above, mm")
      ->check(CLI::NonNegativeNumber);
  add_geometry_options(*command, options->geometry);
  command->callback([options, &exit_code] {
    const auto done = run_compare(*options);
    if (!done) std::cerr << done.error().text();
    exit_code = done ? static_cast<int>(Exit::kDone) : static_cast<int>(done.error().exit);
  });
}

}  // namespace srd::host
