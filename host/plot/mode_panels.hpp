// SPDX-License-Identifier: Apache-2.0
// Small panels in columns, one a mode, under a heading: shared by the figures of coefficients and of their
// errors.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/plot/axis.hpp"
#include "host/plot/figures.hpp"

namespace srd::host {

inline constexpr double kFigureWidth = 960;
inline constexpr double kLeftMargin = 68, kRightMargin = 18;

// Places of `count` equal panels below `top`.
struct PanelGrid {
  PanelGrid(std::size_t count, double top);
  std::size_t count = 0, columns = 1, rows = 1;
  double top = 0;
  [[nodiscard]] Rectangle area(std::size_t i) const;
  // The last panel of its column carries the time axis' numbers.
  [[nodiscard]] bool lowest(std::size_t i) const { return i + columns >= count; }
  [[nodiscard]] double bottom() const;
};

// Bold line and a fainter one at its right end.
void draw_heading(Scene& scene, const std::string& heading, const std::string& remark);

// Time scale of a run: from its first to its last frame.
[[nodiscard]] Scale time_scale(const Timeline& timeline);

// Flagged frames as short marks on a panel's lower edge, coloured by status.
void draw_failures(Scene& scene, const Panel& panel, const PlotInput& input);
// One legend entry a status: "lost: 12 frames".
[[nodiscard]] std::vector<LegendEntry> failure_legend(const PlotInput& input);

// The truth lies under the estimate and is broader, so that both are seen where they agree; less so in a
// crowded figure.
[[nodiscard]] Stroke truth_stroke(const PlotInput& input);

// One coefficient (or its deviation) of all rows; NaN without a surface.
[[nodiscard]] std::vector<double> coefficient_series(const CoefficientRun& run, int mode);
[[nodiscard]] std::vector<double> deviation_series(const CoefficientRun& run, int mode);

// Two deviations each way of what calibration and pose leave alike in all frames. Nothing is drawn where none is known.
void draw_systematic(Scene& scene, const Panel& panel, const Timeline& timeline, std::span<const double> values,
                     std::span<const double> deviations);
[[nodiscard]] LegendEntry systematic_legend();
[[nodiscard]] bool has_systematic(const CoefficientRun& run);

// Least and most of the finite values, widened by those of `more`.
struct Range {
  double low, high;
  Range();
  void cover(std::span<const double> values);
  void cover(double value);
};

[[nodiscard]] double median_of_finite(std::vector<double> values);  // NaN when there is none

}  // namespace srd::host
