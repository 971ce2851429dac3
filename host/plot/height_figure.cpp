// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "host/plot/figures.hpp"
#include "host/plot/mode_panels.hpp"
#include "host/plot/palette.hpp"
#include "host/plot/spectrum.hpp"

namespace srd::host {
namespace {

constexpr Rectangle kSeriesArea{kLeftMargin, 78, kFigureWidth - kLeftMargin - kRightMargin, 170};
constexpr Rectangle kSpectrumArea{kLeftMargin, 332, kFigureWidth - kLeftMargin - kRightMargin, 210};
constexpr double kFigureHeight = 590;

// Heights as the node sent them; where the file has none, from the coefficients.
std::vector<double> height_series(const PlotInput& input) {
  std::vector<double> heights;
  for (const CoefficientRow& row : input.run.rows) heights.push_back(row.height_mm);
  if (std::any_of(heights.begin(), heights.end(), [](double h) { return std::isfinite(h); }) || !input.geometry) return heights;
  const PatternExtent& e = input.geometry->pattern;
  for (std::size_t i = 0; i < heights.size(); ++i)
    if (input.run.rows[i].has_surface())
      heights[i] = input.geometry->model.height(input.run.rows[i].coefficients, e.x_centre(), e.y_centre());
  return heights;
}

std::vector<double> true_heights(const PlotInput& input) {
  std::vector<double> heights;
  if (!input.truth || !input.geometry) return heights;
  dsp::SurfaceModel<double> model = input.geometry->model;
  model.modes = input.truth->modes;
  const PatternExtent& e = input.geometry->pattern;
  for (const auto& a : input.truth->coefficients) heights.push_back(model.height(a, e.x_centre(), e.y_centre()));
  return heights;
}

void draw_peak(Scene& scene, const Panel& panel, const Spectrum& spectrum, std::size_t peak) {
  const Place at = panel.at(spectrum.frequency_hz[peak], spectrum.amplitude[peak]);
  const std::string text = formatted("%.3g Hz: ", spectrum.frequency_hz[peak]) + formatted("%.3g mm", spectrum.amplitude[peak]);
  const bool left = at.x + 8 + text_width(text, 11) > panel.area.right();
  scene.add(Lines{.parts = {{at}}, .stroke = Stroke{kVermilion, 5}});
  scene.add(Text{{at.x + (left ? -5 : 5), at.y - 6}, text, 11, left ? Anchor::kEnd : Anchor::kStart, kInk, true});
}

void draw_spectrum(Scene& scene, const Spectrum& spectrum) {
  const auto largest = std::max_element(spectrum.amplitude.begin(), spectrum.amplitude.end());
  const auto peak = static_cast<std::size_t>(largest - spectrum.amplitude.begin());
  const double floor_level = std::max(median_of_finite(spectrum.amplitude), 1e-7 * *largest);
  Panel panel{kSpectrumArea, {0, spectrum.frequency_hz.back()}, {0, 1, true}};
  // Whole decades round what is to be seen: from below the floor to above the peak.
  panel.y.low = std::pow(10.0, std::floor(std::log10(std::max(0.3 * floor_level, 1e-12))));
  panel.y.high = std::pow(10.0, std::ceil(std::log10(std::max(3 * *largest, 10 * panel.y.low))));
  const PanelLabels labels{.title = "Amplitude spectrum of the height",
                           .x_label = "frequency, Hz",
                           .y_label = "amplitude, mm",
                           .x_unit = "Hz",
                           .y_unit = "mm",
                           .most_x_ticks = 14,
                           .most_y_ticks = 8};
  draw_panel(scene, panel, labels);
  draw_series(scene, panel, spectrum.frequency_hz, spectrum.amplitude, {{0, spectrum.amplitude.size()}}, kEstimateStroke,
              "series");
  if (*largest > 5 * floor_level) draw_peak(scene, panel, spectrum, peak);
  finish_panel(scene, panel, labels);
}

}  // namespace

std::optional<Figure> height_figure(const PlotInput& input) {
  const std::vector<double> heights = height_series(input), real = true_heights(input);
  Range range;
  range.cover(heights);
  if (!std::isfinite(range.low)) return std::nullopt;
  range.cover(real);

  Figure figure{"height", {}, Scene(kFigureWidth, kFigureHeight)};
  Scene& scene = figure.scene;
  draw_heading(scene, "Height at the pattern\u2019s centre", "node " + input.run.node);
  std::vector<LegendEntry> legend{{"estimated", kEstimateStroke}};
  const bool systematic = has_systematic(input.run);
  std::vector<double> shared;
  for (const CoefficientRow& row : input.run.rows) shared.push_back(row.systematic_height);
  if (systematic) legend.push_back(systematic_legend());
  if (const double room = 2 * median_of_finite(shared); std::isfinite(room)) {
    range.cover(range.low - room);
    range.cover(range.high + room);
  }
  if (!real.empty()) legend.push_back({"true", truth_stroke(input)});
  for (LegendEntry& entry : failure_legend(input)) legend.push_back(std::move(entry));
  draw_legend(scene, {kLeftMargin, 46}, legend);

  const Panel panel{kSeriesArea, time_scale(input.timeline), scale_round(range.low, range.high)};
  const PanelLabels labels{.title = "Height",
                           .x_label = "time since the first frame, s",
                           .y_label = "height, mm",
                           .x_unit = "s",
                           .y_unit = "mm",
                           .most_x_ticks = 14,
                           .most_y_ticks = 6};
  draw_panel(scene, panel, labels);
  if (!real.empty()) draw_series(scene, panel, input.truth->seconds, real, {{0, real.size()}}, truth_stroke(input), "true");
  if (systematic) draw_systematic(scene, panel, input.timeline, heights, shared);
  draw_series(scene, panel, input.timeline.seconds, heights, unbroken(input.timeline, heights), kEstimateStroke, "series");
  draw_failures(scene, panel, input);
  finish_panel(scene, panel, labels);
  figure.caption = "Height of the water surface at the pattern\u2019s centre. ";

  const Spectrum spectrum = amplitude_spectrum(input.timeline.seconds, heights, input.timeline.interval_s);
  if (spectrum.amplitude.empty()) {
    scene.add(
        Text{{kSpectrumArea.x, kSpectrumArea.y}, "No spectrum: fewer than 8 frames in a row.", 12, Anchor::kStart, kFaintInk});
    figure.caption += "There are too few frames for a spectrum.";
    return figure;
  }
  draw_spectrum(scene, spectrum);
  figure.caption +=
      "The spectrum is one-sided: a sine of 1 mm shows as 1 mm at its frequency. Hann window, corrected for "
      "its gain; mean removed; samples every " +
      formatted("%.4g", 1e3 * input.timeline.interval_s) + " ms; a line is " + formatted("%.2g", spectrum.resolution_hz) +
      " Hz wide at half its height. ";
  figure.caption += spectrum.filled_fraction > 0 ? formatted("%.2g", 100 * spectrum.filled_fraction) +
                                                       " % of the samples are gaps, filled with the nearest valid height."
                                                 : std::string("No sample is missing.");
  return figure;
}

}  // namespace srd::host
