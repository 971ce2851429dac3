// SPDX-License-Identifier: Apache-2.0
#include "host/plot/axis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "host/plot/palette.hpp"

namespace srd::host {
namespace {

constexpr double kTickText = 10.5, kLabelText = 11, kTitleText = 12;
constexpr double kThinWidth = 0.5;  // of a column that a long series is thinned to

// Lines of the panel, thinned: first, least, most and last of each column.
std::vector<Place> thinned(const Panel& panel, std::span<const double> x, std::span<const double> y, std::size_t from,
                           std::size_t to) {
  std::vector<Place> all;
  all.reserve(to - from);
  for (std::size_t i = from; i < to; ++i) all.push_back(panel.at(x[i], y[i]));
  if (static_cast<double>(all.size()) < 4 * panel.area.width / kThinWidth) return all;
  std::vector<Place> out;
  for (std::size_t i = 0; i < all.size();) {
    const double column = std::floor(all[i].x / kThinWidth);
    std::size_t end = i, least = i, most = i;
    for (; end < all.size() && std::floor(all[end].x / kThinWidth) == column; ++end) {
      if (all[end].y < all[least].y) least = end;
      if (all[end].y > all[most].y) most = end;
    }
    std::array<std::size_t, 4> keep{i, least, most, end - 1};
    std::sort(keep.begin(), keep.end());
    for (std::size_t k = 0; k < keep.size(); ++k)
      if (k == 0 || keep[k] != keep[k - 1]) out.push_back(all[keep[k]]);
    i = end;
  }
  return out;
}

}  // namespace

double Scale::part(double value) const {
  if (!logarithmic) return (value - low) / (high - low);
  return (std::log10(std::max(value, std::numeric_limits<double>::min())) - std::log10(low)) /
         (std::log10(high) - std::log10(low));
}

std::vector<double> ticks(const Scale& wanted, int most) {
  const Scale scale{std::min(wanted.low, wanted.high), std::max(wanted.low, wanted.high), wanted.logarithmic};
  std::vector<double> out;
  if (scale.logarithmic) {
    const int first = static_cast<int>(std::ceil(std::log10(scale.low) - 1e-9));
    const int last = static_cast<int>(std::floor(std::log10(scale.high) + 1e-9));
    const int step = std::max(1, (last - first + most) / std::max(most, 1));
    for (int k = first; k <= last; k += step) out.push_back(std::pow(10.0, k));
    return out;
  }
  const double rough = (scale.high - scale.low) / most;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double least = rough / power * (1 - 1e-9);
  const double step = power * (least <= 1 ? 1 : least <= 2 ? 2 : least <= 5 ? 5 : 10);
  const double first = std::ceil(scale.low / step - 1e-9);
  for (double k = first; k * step <= scale.high + 1e-9 * step; ++k) out.push_back(k == 0 ? 0 : k * step);
  return out;
}

std::string tick_label(double value, const std::vector<double>& all, bool logarithmic) {
  std::array<char, 64> text{};
  if (logarithmic) {
    const double power = std::round(std::log10(value));
    if (std::abs(power) <= 3)
      std::snprintf(text.data(), text.size(), "%.*f", power < 0 ? static_cast<int>(-power) : 0, value);
    else
      std::snprintf(text.data(), text.size(), "1e%d", static_cast<int>(power));
  } else {
    const double step = all.size() > 1 ? all[1] - all[0] : std::max(std::abs(value), 1e-3);
    const double largest = std::max(std::abs(all.empty() ? value : all.front()), std::abs(all.empty() ? value : all.back()));
    const int digits = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 15);
    if (digits > 5 || largest >= 1e7)
      std::snprintf(text.data(), text.size(), "%.4g", value);
    else
      std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  }
  std::string out = text.data();
  if (out.starts_with("-")) out.replace(0, 1, "\u2212");
  return out;
}

Scale scale_round(double low, double high) {
  if (!std::isfinite(low) || !std::isfinite(high)) return {0, 1};
  const double room = std::max({0.08 * (high - low), 1e-6, 1e-9 * std::max(std::abs(low), std::abs(high))});
  return {low - room, high + room};
}

Place Panel::at(double x_value, double y_value) const {
  // Far outside is as good as outside, and keeps numbers in the files short.
  const auto inside = [](double part) { return std::clamp(part, -2.0, 3.0); };
  return {area.x + inside(x.part(x_value)) * area.width, area.bottom() - inside(y.part(y_value)) * area.height};
}

void draw_panel(Scene& scene, const Panel& panel, const PanelLabels& labels) {
  const Rectangle& a = panel.area;
  const Stroke grid{kGrid, 0.7}, tick{kFaintInk, 0.8};
  const auto xs = ticks(panel.x, labels.most_x_ticks), ys = ticks(panel.y, labels.most_y_ticks);
  double widest = 0;
  for (const double x : xs) {
    const double at = panel.at(x, panel.y.low).x;
    scene.line({at, a.y}, {at, a.bottom()}, grid);
    scene.line({at, a.bottom()}, {at, a.bottom() + 4}, tick);
    if (!labels.x_label.empty()) scene.add(Text{{at, a.bottom() + 16}, tick_label(x, xs), kTickText, Anchor::kMiddle, kInk});
  }
  for (const double y : ys) {
    const double at = panel.at(panel.x.low, y).y;
    scene.line({a.x, at}, {a.right(), at}, grid);
    scene.line({a.x - 4, at}, {a.x, at}, tick);
    const std::string label = tick_label(y, ys, panel.y.logarithmic);
    widest = std::max(widest, text_width(label, kTickText));
    scene.add(Text{{a.x - 7, at + 3.7}, label, kTickText, Anchor::kEnd, kInk});
  }
  if (!labels.x_label.empty())
    scene.add(Text{{a.x + a.width / 2, a.bottom() + 33}, labels.x_label, kLabelText, Anchor::kMiddle, kInk});
  if (!labels.y_label.empty())
    scene.add(Text{{a.x - 15 - widest, a.y + a.height / 2}, labels.y_label, kLabelText, Anchor::kMiddle, kInk, false, true});
  if (!labels.title.empty()) scene.add(Text{{a.x, a.y - 6}, labels.title, kTitleText, Anchor::kStart, kInk, true});
  if (!labels.remark.empty()) scene.add(Text{{a.right(), a.y - 6}, labels.remark, kTickText, Anchor::kEnd, kFaintInk});
}

void finish_panel(Scene& scene, const Panel& panel, const PanelLabels& labels) {
  scene.box(panel.area, std::nullopt, Stroke{kFaintInk, 0.8});
  scene.add(AxesMark{panel.area, panel.x.low, panel.x.high, panel.y.low, panel.y.high, panel.y.logarithmic, labels.x_unit,
                     labels.y_unit});
}

void draw_series(Scene& scene, const Panel& panel, std::span<const double> x, std::span<const double> y,
                 const Stretches& stretches, const Stroke& stroke, const std::string& role) {
  Lines lines, dots;
  for (const auto& [from, to] : stretches) {
    if (from >= to) continue;
    auto part = thinned(panel, x, y, from, to);
    (part.size() == 1 ? dots : lines).parts.push_back(std::move(part));
  }
  lines.clip = dots.clip = panel.area;
  lines.role = dots.role = role;
  lines.stroke = stroke;
  dots.stroke = Stroke{stroke.colour, std::max(2.2, stroke.width)};  // a frame between two gaps must be seen
  if (!lines.parts.empty()) scene.add(std::move(lines));
  if (!dots.parts.empty()) scene.add(std::move(dots));
}

void draw_band(Scene& scene, const Panel& panel, std::span<const double> x, std::span<const double> low,
               std::span<const double> high, const Stretches& stretches, const Colour& colour) {
  Lines band{.parts = {}, .stroke = std::nullopt, .fill = colour, .clip = panel.area, .role = {}};
  for (const auto& [from, to] : stretches) {
    if (from >= to) continue;
    std::vector<Place> part = thinned(panel, x, high, from, to);
    const std::vector<Place> back = thinned(panel, x, low, from, to);
    part.insert(part.end(), back.rbegin(), back.rend());
    if (to - from == 1) {  // one frame: as wide as its dot
      part = {{part[0].x - 1, part[0].y}, {part[0].x + 1, part[0].y}, {part[0].x + 1, back[0].y}, {part[0].x - 1, back[0].y}};
    }
    band.parts.push_back(std::move(part));
  }
  if (!band.parts.empty()) scene.add(std::move(band));
}

void draw_legend(Scene& scene, Place at, const std::vector<LegendEntry>& entries) {
  for (const LegendEntry& entry : entries) {
    switch (entry.mark) {
      case LegendMark::kLine: scene.line({at.x, at.y - 4}, {at.x + 22, at.y - 4}, entry.stroke); break;
      case LegendMark::kPatch: scene.box({at.x, at.y - 8, 22, 8}, entry.stroke.colour); break;
      case LegendMark::kTick: scene.line({at.x + 4, at.y - 8}, {at.x + 4, at.y}, entry.stroke); break;
    }
    at.x += entry.mark == LegendMark::kTick ? 11 : 28;
    scene.add(Text{at, entry.text, kLabelText, Anchor::kStart, kInk});
    at.x += text_width(entry.text, kLabelText) + 18;
  }
}

}  // namespace srd::host
