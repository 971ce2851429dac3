// SPDX-License-Identifier: Apache-2.0
// The figures of `srd plot`. Each is one drawing with its caption; a caption says what the lines are and how
// they came.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/compare/comparison.hpp"
#include "host/plot/scene.hpp"
#include "host/plot/timeline.hpp"

namespace srd::host {

// True coefficients along the run's time axis.
struct TrueSeries {
  dsp::ModeList modes;
  std::vector<double> seconds;
  std::vector<dsp::Coefficients<double>> coefficients;  // one a time, mm
};

struct PlotInput {
  CoefficientRun run;
  Timeline timeline;
  std::optional<RunGeometry> geometry;
  std::optional<TrueSeries> truth;
  std::optional<Comparison> comparison;  // with truth only
};

struct Figure {
  std::string name;     // part of the file's name: "series"
  std::string caption;  // plain text
  Scene scene;
};

// Truth rows within the run's time (kTime), or at the times of the run's rows (kOrder).
[[nodiscard]] TrueSeries true_series(const CoefficientRun& run, const Timeline& timeline, const Truth& truth, MatchBy by);

// Every mode over time, a panel each.
[[nodiscard]] Figure coefficient_figure(const PlotInput& input);
// Height at the pattern's centre over time, and its amplitude spectrum. Nothing when the run has no heights.
[[nodiscard]] std::optional<Figure> height_figure(const PlotInput& input);
// Surface of one frame over the pattern. input.geometry is needed, and a row with a surface.
[[nodiscard]] Figure surface_figure(const PlotInput& input, std::size_t row);
// Estimated minus true over time. input.comparison is needed.
[[nodiscard]] Figure error_figure(const PlotInput& input);

}  // namespace srd::host
