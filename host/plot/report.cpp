// SPDX-License-Identifier: Apache-2.0
#include "host/plot/report.hpp"

#include <cmath>

#include "drivers/support/formatted.hpp"
#include "drivers/support/text_file.hpp"
#include "host/coefficients/columns.hpp"
#include "host/plot/figures.hpp"
#include "host/plot/mode_panels.hpp"
#include "host/plot/page.hpp"
#include "host/plot/png.hpp"
#include "host/plot/svg.hpp"

namespace srd::host {
namespace {

struct Gathered {
  PlotInput input;
  std::size_t shown = 0;  // row whose surface is drawn
  std::vector<std::string> notes;
};

Outcome<std::size_t> choose_frame(const CoefficientRun& run, const std::optional<std::uint64_t>& wanted) {
  std::size_t shown = run.rows.size();
  bool there = false;
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    if (wanted && run.rows[i].sequence != *wanted) continue;
    there = true;
    if (run.rows[i].has_surface()) shown = i;
  }
  if (shown < run.rows.size()) return shown;
  return Problem{Exit::kUsage,
                 there ? "frame " + std::to_string(*wanted) + " has no surface" : "no such frame",
                 run.file,
                 "--frame with the sequence of a frame that has a surface",
                 there ? "" : std::to_string(*wanted),
                 ""};
}

Outcome<Gathered> gather(const PlotOptions& options) {
  auto run = read_coefficient_run(options.file, options.node);
  if (!run) return run.error();
  if (auto usable = require_surface(*run); !usable) return usable.error();
  auto geometry = resolve_geometry(*run, options.geometry);
  if (!geometry) return geometry.error();
  const auto shown = choose_frame(*run, options.frame);
  if (!shown) return shown.error();
  Gathered g{{std::move(*run), {}, std::move(*geometry), {}, {}}, *shown, {}};
  g.input.timeline = make_timeline(g.input.run);
  g.notes = g.input.run.notes;
  if (!g.input.geometry)
    g.notes.emplace_back(
        "No surface is drawn: the model\u2019s lengths and the pattern are not known (give --model, or --lx, "
        "--ly and --points).");
  if (options.truth) {
    const MatchBy by = options.by_order ? MatchBy::kOrder : MatchBy::kTime;
    const auto truth = read_truth(*options.truth);
    if (!truth) return truth.error();
    auto comparison = compare(g.input.run, *truth, options.truth->string(), by, g.input.geometry);
    if (!comparison) return comparison.error();
    g.input.comparison = std::move(*comparison);
    g.input.truth = true_series(g.input.run, g.input.timeline, *truth, by);
  }
  return g;
}

std::uint64_t missing_frames(const CoefficientRun& run) {
  std::uint64_t missing = 0;
  for (std::size_t i = 1; i < run.rows.size(); ++i)
    if (run.rows[i].boot == run.rows[i - 1].boot) missing += missing_between(run.rows[i - 1], run.rows[i]);
  return missing;
}

std::vector<std::pair<std::string, std::string>> facts_of(const PlotInput& input) {
  const CoefficientRun& run = input.run;
  const std::uint64_t missing = missing_frames(run);
  std::vector<std::pair<std::string, std::string>> facts{{"File", std::filesystem::path(run.file).filename().string()},
                                                         {"Node", run.node}};
  const std::size_t surfaces = run.surfaces();
  const std::string with = surfaces == run.rows.size() ? "all" : std::to_string(surfaces);
  facts.emplace_back("Frames", std::to_string(run.rows.size()) + ", " + with + " with a surface" +
                                   (missing > 0 ? ", " + std::to_string(missing) + " missing" : ""));
  facts.emplace_back(
      "Time", formatted("%.6g s", input.timeline.seconds.back()) +
                  (input.timeline.interval_s > 0 ? ", " + formatted("%.4g frames/s", 1 / input.timeline.interval_s) : "") +
                  ", clock " + run.clock);
  double sum = 0, n = 0;
  for (const CoefficientRow& row : run.rows)
    if (row.has_surface() && std::isfinite(row.mean_error)) {
      sum += row.mean_error;
      ++n;
    }
  if (n > 0) facts.emplace_back("Mean error", formatted("%.3g ", sum / n) + error_unit(run.metric) + " (" + run.metric + ")");
  std::vector<double> shared;
  for (const CoefficientRow& row : run.rows)
    if (row.has_surface()) shared.push_back(row.systematic_height);
  if (const double usual = median_of_finite(shared); std::isfinite(usual))
    facts.emplace_back("Systematic deviation of heights",
                       formatted("%.3g mm", usual) + (input.geometry && input.geometry->systematic
                                                          ? ", of errors of " + sources_text(*input.geometry->systematic)
                                                          : std::string()));
  if (input.geometry) {
    const RunGeometry& g = *input.geometry;
    facts.emplace_back("Model", std::to_string(run.modes.size()) + " modes, Lx " + formatted("%.6g", g.model.lx) + " mm, Ly " +
                                    formatted("%.6g", g.model.ly) + " mm, origin (" + formatted("%.6g", g.model.x0) + ", " +
                                    formatted("%.6g", g.model.y0) + ") mm");
    if (g.refractive_index)
      facts.emplace_back("Refractive index", formatted("%.5f, ", *g.refractive_index) + plates_text(g.plates));
  }
  return facts;
}

PageTable error_table(const PlotInput& input) {
  const Comparison& c = *input.comparison;
  PageTable table{"Estimated minus true over " + std::to_string(c.frames.size()) +
                      " frames, mm. rms / sd compares the errors with the stated standard deviations: 1 when "
                      "those are right.",
                  {"", "rms", "mean", "largest", "rms / sd", "spread of the true values"},
                  {}};
  if (input.geometry) {
    table.rows.push_back({"Surface over the pattern", formatted("%.4f", c.surface_rms), "",
                          formatted("%.4f (worst frame\u2019s rms)", c.surface_largest), "", ""});
    table.rows.push_back(
        {"Height at the centre", formatted("%.4f", c.height_rms), formatted("%+.4f", c.height_mean), "", "", ""});
  }
  for (int j = 0; j < c.modes.size(); ++j) {
    const ModeSummary& s = c.summary[static_cast<std::size_t>(j)];
    table.rows.push_back({c.modes[j].name().data(), formatted("%.4f", s.rms), formatted("%+.4f", s.mean),
                          formatted("%.4f", s.largest), std::isfinite(s.normalised) ? formatted("%.2f", s.normalised) : "",
                          formatted("%.4f", s.true_spread)});
  }
  return table;
}

Outcome<void> refuse_to_replace(const std::vector<std::filesystem::path>& files) {
  std::error_code error;
  for (const auto& file : files)
    if (std::filesystem::exists(file, error))
      return Problem{
          Exit::kUsage, "the file is there already", file.string(), "", "", "another --out DIR, or --force to replace it"};
  return {};
}

}  // namespace

Outcome<PlotFiles> plot(const PlotOptions& options) {
  auto gathered = gather(options);
  if (!gathered) return gathered.error();
  const PlotInput& input = gathered->input;
  std::vector<Figure> figures;
  figures.push_back(coefficient_figure(input));
  if (auto height = height_figure(input)) figures.push_back(std::move(*height));
  if (input.geometry) figures.push_back(surface_figure(input, gathered->shown));
  if (input.comparison) figures.push_back(error_figure(input));

  Page page{"Water surface, node " + input.run.node, facts_of(input), gathered->notes, {}, {}};
  const std::filesystem::path folder = options.out.value_or(options.file.parent_path());
  const std::string stem = options.file.stem().string();
  PlotFiles files{{folder / (stem + ".html")}, gathered->notes};
  for (const Figure& figure : figures) {
    auto svg = svg_element(figure.scene, figure.caption);
    if (!svg) return svg.error();
    page.figures.push_back({std::move(*svg), figure.caption});
    files.written.push_back(folder / (stem + "-" + figure.name + ".png"));
  }
  if (input.comparison) page.tables.push_back(error_table(input));

  if (!options.force)
    if (auto free = refuse_to_replace(files.written); !free) return free.error();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error)
    return Problem{Exit::kInput,    "the folder cannot be made", folder.string(), "a folder that can be written",
                   error.message(), "another --out DIR"};
  if (auto done = write_text_file(files.written[0], page_html(page)); !done) return done.error();
  for (std::size_t i = 0; i < figures.size(); ++i)
    if (auto done = write_png(figures[i].scene, files.written[i + 1]); !done) return done.error();
  return files;
}

}  // namespace srd::host
