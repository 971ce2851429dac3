// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "host/plot/figures.hpp"
#include "host/plot/mode_panels.hpp"
#include "host/plot/palette.hpp"

#include "host/coefficients/columns.hpp"
#include "host/plot/contour.hpp"

namespace srd::host {
namespace {

constexpr double kMapTop = 78, kBarRoom = 110, kMaxHeight = 560, kBarWidth = 16, kBarGap = 22;
constexpr double kMinRange = 0.01;  // mm, of the colours
constexpr int kPixelsAlong = 480, kGridAlong = 160;

// The frame seen from above with Y to the right and X downwards, as the reference image shows the pattern.
struct Map {
  const RunGeometry& geometry;
  const dsp::Coefficients<double>& a;
  Panel panel;  // x: Y of the world; y: X of the world, downwards

  [[nodiscard]] double height(double across, double down) const {  // parts of the extent, 0 to 1
    const PatternExtent& e = geometry.pattern;
    return geometry.model.height(a, e.x_min + down * (e.x_max - e.x_min), e.y_min + across * (e.y_max - e.y_min));
  }
};

Map lay_out(const RunGeometry& geometry, const dsp::Coefficients<double>& a) {
  const PatternExtent& e = geometry.pattern;
  const double along = e.y_max - e.y_min, across = e.x_max - e.x_min;
  const double width = kFigureWidth - kLeftMargin - kBarRoom;
  const double scale = std::min(width / along, kMaxHeight / across);
  const Rectangle area{kLeftMargin + 0.5 * (width - scale * along), kMapTop, scale * along, scale * across};
  return {geometry, a, Panel{area, {e.y_min, e.y_max}, {e.x_max, e.x_min}}};
}

Image coloured(const Map& map, const Scale& heights) {
  const Rectangle& area = map.panel.area;
  const int columns = kPixelsAlong;
  const int rows = std::max(2, static_cast<int>(std::lround(columns * area.height / area.width)));
  Image image{area, columns, rows, {}};
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const Colour c = viridis(heights.part(map.height((x + 0.5) / columns, (y + 0.5) / rows)));
      image.rgb.insert(image.rgb.end(), {c.red, c.green, c.blue});
    }
  return image;
}

struct Contour {
  std::vector<std::vector<Place>> lines;  // in the drawing
  double level;
};

std::vector<Contour> contours(const Map& map, const std::vector<double>& levels) {
  const Rectangle& area = map.panel.area;
  const int columns = kGridAlong + 1;
  const int rows = std::max(8, static_cast<int>(std::lround(kGridAlong * area.height / area.width))) + 1;
  Eigen::MatrixXd z(rows, columns);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      z(y, x) = map.height(static_cast<double>(x) / (columns - 1), static_cast<double>(y) / (rows - 1));
  std::vector<Contour> out;
  for (const double level : levels) {
    Contour contour{contour_lines(z, level), level};
    for (auto& line : contour.lines)
      for (Place& p : line) p = {area.x + p.x / (columns - 1) * area.width, area.y + p.y / (rows - 1) * area.height};
    out.push_back(std::move(contour));
  }
  return out;
}

// Light lines on the dark half of the map, dark ones on the light half.
Colour line_colour(double part) { return part < 0.55 ? faded(kWhite, 0.9) : faded(kBlack, 0.75); }

// One label a line where it does not touch the border or another label; a line without such a place has none.
void label_contours(Scene& scene, const Rectangle& area, const std::vector<Contour>& all, const std::vector<double>& levels,
                    const Scale& heights) {
  std::vector<Rectangle> taken;
  for (const Contour& contour : all)
    for (const auto& line : contour.lines) {
      if (line.size() < 12) continue;
      const std::string text = tick_label(contour.level, levels);
      const double width = text_width(text, 10) + 4;
      for (const double part : {0.5, 0.35, 0.65, 0.2, 0.8}) {
        const Place p = line[static_cast<std::size_t>(part * static_cast<double>(line.size() - 1))];
        const Rectangle box{p.x - width / 2, p.y - 7, width, 14};
        const bool inside =
            box.x > area.x + 2 && box.right() < area.right() - 2 && box.y > area.y + 2 && box.bottom() < area.bottom() - 2;
        const auto meets = [&](const Rectangle& r) {
          return box.x < r.right() + 6 && r.x < box.right() + 6 && box.y < r.bottom() + 4 && r.y < box.bottom() + 4;
        };
        if (!inside || std::any_of(taken.begin(), taken.end(), meets)) continue;
        taken.push_back(box);
        scene.box(box, viridis(heights.part(contour.level)));  // interrupts the line under the label
        scene.add(Text{{p.x, p.y + 3.5}, text, 10, Anchor::kMiddle, line_colour(heights.part(contour.level))});
        break;
      }
    }
}

void draw_colour_bar(Scene& scene, const Rectangle& map, const Scale& heights, const std::vector<double>& levels) {
  const Rectangle bar{map.right() + kBarGap, map.y, kBarWidth, map.height};
  Image image{bar, 1, 256, {}};
  for (int y = 0; y < image.height; ++y) {
    const Colour c = viridis(1 - (y + 0.5) / image.height);
    image.rgb.insert(image.rgb.end(), {c.red, c.green, c.blue});
  }
  scene.add(std::move(image));
  scene.box(bar, std::nullopt, Stroke{kFaintInk, 0.8});
  double widest = 0;
  for (const double level : levels) {
    const double y = bar.bottom() - heights.part(level) * bar.height;
    const std::string text = tick_label(level, levels);
    scene.line({bar.right(), y}, {bar.right() + 4, y}, Stroke{kFaintInk, 0.8});
    scene.add(Text{{bar.right() + 7, y + 3.7}, text, 10.5, Anchor::kStart, kInk});
    widest = std::max(widest, text_width(text, 10.5));
  }
  scene.add(Text{{bar.right() + 22 + widest, bar.y + bar.height / 2}, "height, mm", 11, Anchor::kMiddle, kInk, false, true});
}

}  // namespace

Figure surface_figure(const PlotInput& input, std::size_t row) {
  const CoefficientRow& frame = input.run.rows[row];
  const Map map = lay_out(*input.geometry, frame.coefficients);
  const Rectangle& area = map.panel.area;
  Figure figure{"surface", {}, Scene(kFigureWidth, area.bottom() + 48)};
  Scene& scene = figure.scene;

  Range range;
  for (int y = 0; y <= kGridAlong; ++y)
    for (int x = 0; x <= kGridAlong; ++x)
      range.cover(map.height(static_cast<double>(x) / kGridAlong, static_cast<double>(y) / kGridAlong));
  // A level surface shows one colour, not its last digits.
  const double room = std::max(0.0, kMinRange - (range.high - range.low)) / 2;
  const Scale heights{range.low - room, range.high + room};
  const std::vector<double> levels = ticks(heights, area.height < 160 ? 5 : 10);

  draw_heading(scene, "Water surface over the pattern", "node " + input.run.node);
  std::string about = "sequence " + std::to_string(frame.sequence) + ", " + formatted("%.4g s", input.timeline.seconds[row]) +
                      " after the first frame";
  if (std::isfinite(frame.mean_error))
    about += ", mean error " + formatted("%.3g ", frame.mean_error) + error_unit(input.run.metric);
  if (std::isfinite(frame.corners_used)) about += ", " + formatted("%.0f corners", frame.corners_used);
  scene.add(Text{{kLeftMargin, 46}, about, 11, Anchor::kStart, kFaintInk});

  const PanelLabels labels{.x_label = "Y (streamwise), mm", .y_label = "X (crosswise), mm", .x_unit = "mm", .y_unit = "mm"};
  draw_panel(scene, map.panel, labels);
  scene.add(coloured(map, heights));
  const std::vector<Contour> lines = contours(map, levels);
  for (const Contour& contour : lines)
    scene.add(Lines{.parts = contour.lines, .stroke = Stroke{line_colour(heights.part(contour.level)), 0.7}, .clip = area});
  Lines corners{.parts = {}, .stroke = Stroke{faded(kBlack, 0.45), 1.6}};
  for (const auto& p : input.geometry->corners) corners.parts.push_back({map.panel.at(p.y(), p.x())});
  if (!corners.parts.empty()) scene.add(std::move(corners));
  label_contours(scene, area, lines, levels, heights);
  finish_panel(scene, map.panel, labels);
  draw_colour_bar(scene, area, heights, levels);

  figure.caption =
      "Height of the water surface above the pattern\u2019s plane, seen from above, over the pattern\u2019s "
      "extent; "
      "contour lines at the numbers of the colour bar.";
  if (!input.geometry->corners.empty()) figure.caption += " Dots: the pattern\u2019s corners.";
  return figure;
}

}  // namespace srd::host
