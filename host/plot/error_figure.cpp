// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "drivers/support/mode_names.hpp"
#include "host/plot/figures.hpp"
#include "host/plot/mode_panels.hpp"
#include "host/plot/palette.hpp"

namespace srd::host {
namespace {

constexpr Stroke kErrorStroke{kBlue, 1.0};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Rectangle kSurfaceArea{kLeftMargin, 78, kFigureWidth - kLeftMargin - kRightMargin, 120};

std::string rms_text(double rms, const char* unit) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "rms %.3g %s", rms, unit);
  return text.data();
}

// Scales every value of a series onto the run's rows; NaN where there is no error to show.
template <class Value>
std::vector<double> by_row(const PlotInput& input, Value value) {
  std::vector<double> out(input.run.rows.size(), kNaN);
  for (const FrameError& frame : input.comparison->frames) out[frame.row] = value(frame);
  return out;
}

void draw_surface_rms(Scene& scene, const PlotInput& input) {
  const std::vector<double> values = by_row(input, [](const FrameError& f) { return f.surface_rms; });
  const double largest = input.comparison->surface_largest;
  const Panel panel{kSurfaceArea, time_scale(input.timeline), {0, largest > 0 ? 1.1 * largest : 1e-6}};
  const PanelLabels labels{.title = "Surface over the pattern, rms, mm",
                           .remark = rms_text(input.comparison->surface_rms, "mm"),
                           .x_label = "time since the first frame, s",
                           .x_unit = "s",
                           .y_unit = "mm",
                           .most_x_ticks = 12};
  draw_panel(scene, panel, labels);
  draw_series(scene, panel, input.timeline.seconds, values, unbroken(input.timeline, values), kErrorStroke, "series");
  draw_failures(scene, panel, input);
  finish_panel(scene, panel, labels);
}

}  // namespace

Figure error_figure(const PlotInput& input) {
  const Comparison& comparison = *input.comparison;
  const bool with_surface = input.geometry.has_value();
  const PanelGrid grid(static_cast<std::size_t>(comparison.modes.size()), with_surface ? kSurfaceArea.bottom() + 40 : 52);
  Figure figure{"errors", {}, Scene(kFigureWidth, grid.bottom())};
  Scene& scene = figure.scene;
  draw_heading(scene, "Estimated minus true", "node " + input.run.node);
  std::vector<LegendEntry> legend{{"estimated \u2212 true", kErrorStroke},
                                  {"\u00B12 stated random deviations", {kBandColour}, LegendMark::kPatch}};
  const bool systematic = has_systematic(input.run);
  if (systematic) legend.push_back(systematic_legend());
  for (LegendEntry& entry : failure_legend(input)) legend.push_back(std::move(entry));
  draw_legend(scene, {kLeftMargin, 46}, legend);
  if (with_surface) draw_surface_rms(scene, input);

  for (int j = 0; j < comparison.modes.size(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    const int at_run = input.run.modes.index_of(comparison.modes[j]);
    const std::vector<double> values = by_row(input, [&](const FrameError& f) { return f.mode[i]; });
    std::vector<double> low =
        by_row(input, [&](const FrameError& f) { return -2 * input.run.rows[f.row].standard_deviation[at_run]; });
    std::vector<double> high = low;
    for (double& h : high) h = -h;
    Range range;
    range.cover(values);
    const double usual = median_of_finite(high);
    range.cover(usual);
    range.cover(-usual);
    range.cover(0.0);
    const std::vector<double> none = by_row(input, [](const FrameError&) { return 0.0; });
    const std::vector<double> shared =
        by_row(input, [&](const FrameError& f) { return input.run.rows[f.row].systematic_deviation[at_run]; });
    if (const double room = 2 * median_of_finite(shared); std::isfinite(room)) {
      range.cover(room);
      range.cover(-room);
    }

    const Panel panel{grid.area(i), time_scale(input.timeline), scale_round(range.low, range.high)};
    PanelLabels labels{.title = mode_name(comparison.modes[j]) + ", mm",
                       .remark = rms_text(comparison.summary[i].rms, "mm"),
                       .x_unit = "s",
                       .y_unit = "mm",
                       .most_x_ticks = grid.columns == 1 ? 12 : 7};
    if (grid.lowest(i)) labels.x_label = "time since the first frame, s";
    draw_panel(scene, panel, labels);
    draw_band(scene, panel, input.timeline.seconds, low, high, unbroken(input.timeline, low), kBandColour);
    const Place zero = panel.at(0, 0);
    scene.line({panel.area.x, zero.y}, {panel.area.right(), zero.y}, Stroke{kFaintInk, 0.7});
    if (systematic) draw_systematic(scene, panel, input.timeline, none, shared);
    draw_series(scene, panel, input.timeline.seconds, values, unbroken(input.timeline, values), kErrorStroke, "series");
    draw_failures(scene, panel, input);
    finish_panel(scene, panel, labels);
  }
  figure.caption =
      std::string("Estimated minus true") +
      (with_surface ? ", at the top as the rms over the pattern\u2019s places of each frame, then each coefficient"
                    : " coefficients") +
      ", with a band of two stated random deviations each way" +
      (systematic ? ", and lines at two systematic ones: where errors of calibration and pose may have moved all of "
                    "it."
                  : ".");
  return figure;
}

}  // namespace srd::host
