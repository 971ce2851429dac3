// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "drivers/support/mode_names.hpp"
#include "host/plot/figures.hpp"
#include "host/plot/mode_panels.hpp"
#include "host/plot/palette.hpp"

namespace srd::host {
namespace {

constexpr double kLegendAt = 46, kPanelsFrom = 52;

}  // namespace

TrueSeries true_series(const CoefficientRun& run, const Timeline& timeline, const Truth& truth, MatchBy by) {
  TrueSeries series{truth.modes, {}, {}};
  for (std::size_t i = 0; i < truth.rows.size(); ++i) {
    const double at = by == MatchBy::kTime          ? static_cast<double>(truth.rows[i].time_ns - run.rows[0].time_ns) * 1e-9
                      : i < timeline.seconds.size() ? timeline.seconds[i]
                                                    : -1;
    if (at < 0 || at > timeline.seconds.back()) continue;
    series.seconds.push_back(at);
    series.coefficients.push_back(truth.rows[i].coefficients);
  }
  return series;
}

Figure coefficient_figure(const PlotInput& input) {
  const CoefficientRun& run = input.run;
  const PanelGrid grid(static_cast<std::size_t>(run.modes.size()), kPanelsFrom);
  Figure figure{"series", {}, Scene(kFigureWidth, grid.bottom())};
  Scene& scene = figure.scene;
  draw_heading(scene, "Surface coefficients", "node " + run.node);
  std::vector<LegendEntry> legend{{"estimated", kEstimateStroke},
                                  {"\u00B12 random standard deviations", {kBandColour}, LegendMark::kPatch}};
  const bool systematic = has_systematic(run);
  if (systematic) legend.push_back(systematic_legend());
  if (input.truth) legend.push_back({"true", truth_stroke(input)});
  for (LegendEntry& entry : failure_legend(input)) legend.push_back(std::move(entry));
  draw_legend(scene, {kLeftMargin, kLegendAt}, legend);

  for (int j = 0; j < run.modes.size(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    const std::vector<double> values = coefficient_series(run, j), deviations = deviation_series(run, j);
    std::vector<double> low(values.size()), high(values.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      low[k] = values[k] - 2 * deviations[k];
      high[k] = values[k] + 2 * deviations[k];
    }
    // A single frame with a wide deviation must not squeeze the curve: the usual deviation sets the room.
    Range range;
    range.cover(values);
    const double usual = 2 * median_of_finite(deviations);
    if (std::isfinite(usual)) {
      range.cover(range.low - usual);
      range.cover(range.high + usual);
    }
    std::vector<double> shared;
    for (const CoefficientRow& row : run.rows) shared.push_back(row.systematic_deviation[j]);
    if (const double room = 2 * median_of_finite(shared); std::isfinite(room)) {
      range.cover(range.low - room);
      range.cover(range.high + room);
    }
    std::vector<double> true_values;
    const int at_truth = input.truth ? input.truth->modes.index_of(run.modes[j]) : -1;
    if (at_truth >= 0)
      for (const auto& a : input.truth->coefficients) true_values.push_back(a[at_truth]);
    range.cover(true_values);

    const Panel panel{grid.area(i), time_scale(input.timeline), scale_round(range.low, range.high)};
    PanelLabels labels{
        .title = mode_name(run.modes[j]) + ", mm", .x_unit = "s", .y_unit = "mm", .most_x_ticks = grid.columns == 1 ? 12 : 7};
    if (grid.lowest(i)) labels.x_label = "time since the first frame, s";
    draw_panel(scene, panel, labels);
    if (!true_values.empty())
      draw_series(scene, panel, input.truth->seconds, true_values, {{0, true_values.size()}}, truth_stroke(input), "true");
    draw_band(scene, panel, input.timeline.seconds, low, high, unbroken(input.timeline, low), kBandColour);
    if (systematic) draw_systematic(scene, panel, input.timeline, values, shared);
    draw_series(scene, panel, input.timeline.seconds, values, unbroken(input.timeline, values), kEstimateStroke, "series");
    draw_failures(scene, panel, input);
    finish_panel(scene, panel, labels);
  }
  figure.caption =
      "Coefficients of the surface model, one panel a mode, with a band of two random standard deviations each way. "
      "Lines stop where frames are missing or have no surface";
  if (systematic)
    figure.caption +=
        "; the lines beside show two systematic deviations each way: what errors of calibration and pose leave alike in all "
        "frames";
  if (!failure_legend(input).empty())
    figure.caption +=
        "; frames without a surface, or with one that the node doubts, are marked along the time axis in the "
        "colour of "
        "their status";
  figure.caption += ".";
  return figure;
}

}  // namespace srd::host
