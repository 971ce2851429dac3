// SPDX-License-Identifier: Apache-2.0
#include "host/plot/mode_panels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "host/plot/palette.hpp"

namespace srd::host {
namespace {

constexpr double kPanelHeight = 104, kTitleRoom = 30, kColumnGap = 72, kAxisRoom = 44;

}  // namespace

PanelGrid::PanelGrid(std::size_t panels, double from_top) : count(panels), top(from_top) {
  columns = count <= 3 ? 1 : count <= 12 ? 2 : 3;
  rows = (count + columns - 1) / columns;
}

Rectangle PanelGrid::area(std::size_t i) const {
  const auto n = static_cast<double>(columns);
  const double width = (kFigureWidth - kLeftMargin - kRightMargin - (n - 1) * kColumnGap) / n;
  const auto column = static_cast<double>(i % columns), row = static_cast<double>(i / columns);
  return {kLeftMargin + column * (width + kColumnGap), top + kTitleRoom + row * (kPanelHeight + kTitleRoom), width,
          kPanelHeight};
}

double PanelGrid::bottom() const { return area(count - 1).bottom() + kAxisRoom; }

void draw_heading(Scene& scene, const std::string& heading, const std::string& remark) {
  scene.add(Text{{kLeftMargin, 24}, heading, 15, Anchor::kStart, kInk, true});
  scene.add(Text{{kFigureWidth - kRightMargin, 24}, remark, 11, Anchor::kEnd, kFaintInk});
}

Scale time_scale(const Timeline& timeline) {
  const double end = timeline.seconds.back();
  return {0, end > 0 ? end : std::max(timeline.interval_s, 1e-3)};
}

void draw_failures(Scene& scene, const Panel& panel, const PlotInput& input) {
  std::map<std::string, std::set<long>> columns;  // half units: marks that would lie on each other are one
  for (std::size_t i = 0; i < input.run.rows.size(); ++i)
    if (input.run.rows[i].is_flagged())
      columns[input.run.rows[i].status].insert(std::lround(2 * panel.at(input.timeline.seconds[i], panel.y.low).x));
  for (const auto& [status, places] : columns) {
    Lines marks{.parts = {}, .stroke = Stroke{status_colour(status), 1}, .fill = std::nullopt, .clip = panel.area, .role = {}};
    for (const long place : places) {
      const double x = 0.5 * static_cast<double>(place);
      marks.parts.push_back({{x, panel.area.bottom() - 7}, {x, panel.area.bottom()}});
    }
    scene.add(std::move(marks));
  }
}

std::vector<LegendEntry> failure_legend(const PlotInput& input) {
  std::map<std::string, std::size_t> counts;
  for (const CoefficientRow& row : input.run.rows)
    if (row.is_flagged()) ++counts[row.status];
  std::vector<LegendEntry> entries;
  for (const auto& [status, count] : counts)
    entries.push_back({status + ": " + std::to_string(count) + (count == 1 ? " frame" : " frames"),
                       {status_colour(status), 1.6},
                       LegendMark::kTick});
  return entries;
}

Stroke truth_stroke(const PlotInput& input) {
  constexpr std::size_t kCrowded = 500;
  return input.timeline.seconds.size() < kCrowded ? Stroke{faded(kOrange, 0.8), 3.6} : Stroke{kOrange, 2.2};
}

std::vector<double> coefficient_series(const CoefficientRun& run, int mode) {
  std::vector<double> out;
  for (const CoefficientRow& row : run.rows) out.push_back(row.coefficients[mode]);
  return out;
}

std::vector<double> deviation_series(const CoefficientRun& run, int mode) {
  std::vector<double> out;
  for (const CoefficientRow& row : run.rows)
    out.push_back(row.has_surface() ? row.standard_deviation[mode] : std::numeric_limits<double>::quiet_NaN());
  return out;
}

void draw_systematic(Scene& scene, const Panel& panel, const Timeline& timeline, std::span<const double> values,
                     std::span<const double> deviations) {
  for (const double side : {-2.0, 2.0}) {
    std::vector<double> edge(values.size());
    for (std::size_t k = 0; k < values.size(); ++k) edge[k] = values[k] + side * deviations[k];
    draw_series(scene, panel, timeline.seconds, edge, unbroken(timeline, edge), kSystematicStroke, "systematic");
  }
}

LegendEntry systematic_legend() { return {"\u00B12 systematic deviations", kSystematicStroke}; }

bool has_systematic(const CoefficientRun& run) {
  return std::any_of(run.rows.begin(), run.rows.end(),
                     [](const CoefficientRow& row) { return row.has_surface() && std::isfinite(row.systematic_height); });
}

Range::Range() : low(std::numeric_limits<double>::infinity()), high(-low) {}

void Range::cover(double value) {
  if (!std::isfinite(value)) return;
  low = std::min(low, value);
  high = std::max(high, value);
}

void Range::cover(std::span<const double> values) {
  for (const double value : values) cover(value);
}

double median_of_finite(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace srd::host
