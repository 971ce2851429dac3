// SPDX-License-Identifier: Apache-2.0
// Panels: a rectangle of the drawing with a scale each way, ticks at round numbers, lines, bands and marks in
// it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/plot/scene.hpp"

namespace srd::host {

struct Scale {
  double low = 0,
         high = 1;  // different; low above high: the axis runs the other way; both above 0 when logarithmic
  bool logarithmic = false;
  // 0 at low, 1 at high.
  [[nodiscard]] double part(double value) const;
};

// Multiples of 1, 2 or 5 times a power of ten inside [low, high], at most `most` of them; logarithmic: powers
// of ten.
[[nodiscard]] std::vector<double> ticks(const Scale& scale, int most);
// With as many digits as the ticks' distance needs: "-0.05", "80", "1e-3".
[[nodiscard]] std::string tick_label(double value, const std::vector<double>& all, bool logarithmic = false);

// A scale round the values (others than finite ones are left out) with a little room, never of no extent.
[[nodiscard]] Scale scale_round(double low, double high);

struct Panel {
  Rectangle area;
  Scale x, y;
  [[nodiscard]] Place at(double x_value, double y_value) const;
};

struct PanelLabels {
  std::string title{};             // above the panel's top left corner
  std::string remark{};            // above its top right corner
  std::string x_label{};           // under the ticks; empty: ticks without numbers
  std::string y_label{};           // upwards, left of the ticks
  std::string x_unit{}, y_unit{};  // for the page's read-out
  int most_x_ticks = 10, most_y_ticks = 5;
};

// Grid, frame, ticks and labels. Draw it first, lines after it, and finish_panel last.
void draw_panel(Scene& scene, const Panel& panel, const PanelLabels& labels);
// The frame once more over what was drawn, and the mark for the page's script.
void finish_panel(Scene& scene, const Panel& panel, const PanelLabels& labels);

// Half-open ranges of indices that one line may join.
using Stretches = std::vector<std::pair<std::size_t, std::size_t>>;

// Long series are thinned to the extremes of each half unit of width: no peak is lost, and files stay small.
void draw_series(Scene& scene, const Panel& panel, std::span<const double> x, std::span<const double> y,
                 const Stretches& stretches, const Stroke& stroke, const std::string& role = {});
void draw_band(Scene& scene, const Panel& panel, std::span<const double> x, std::span<const double> low,
               std::span<const double> high, const Stretches& stretches, const Colour& colour);

// One row of marks and their meanings, from the left.
enum class LegendMark : std::uint8_t { kLine, kPatch, kTick };
struct LegendEntry {
  std::string text;
  Stroke stroke;
  LegendMark mark = LegendMark::kLine;
};
void draw_legend(Scene& scene, Place at, const std::vector<LegendEntry>& entries);

}  // namespace srd::host
