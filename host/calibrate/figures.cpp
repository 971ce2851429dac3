// SPDX-License-Identifier: Apache-2.0
#include "host/calibrate/figures.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "host/bundle/lens.hpp"
#include "host/plot/axis.hpp"
#include "host/plot/contour.hpp"
#include "host/plot/mode_panels.hpp"
#include "host/plot/palette.hpp"

namespace srd::host {

namespace {

constexpr double kTop = 78, kBarWidth = 16, kBarGap = 22, kBarRoom = 90;
constexpr double kArrowPx = 60;  // of the drawing, for the longest usual residual

Panel image_panel(const CalibrationResult& result, double room_right) {
  const double width = kFigureWidth - kLeftMargin - kRightMargin - room_right;
  const Rectangle area{kLeftMargin, kTop, width, width * result.height / result.width};
  return {area, {-0.5, result.width - 0.5}, {result.height - 0.5, -0.5}};
}

PanelLabels pixel_labels(const std::string& title) {
  return {.title = title,
          .x_label = "u, px",
          .y_label = "v, px",
          .x_unit = "px",
          .y_unit = "px",
          .most_x_ticks = 12,
          .most_y_ticks = 8};
}

Scene scene_for(const Panel& panel) { return {kFigureWidth, panel.area.bottom() + 46}; }

// A length that arrows are scaled by: a round number near to three times the rms.
double round_length(double px) {
  const double power = std::pow(10.0, std::floor(std::log10(px)));
  for (const double step : {1.0, 2.0, 5.0})
    if (step * power >= px) return step * power;
  return 10 * power;
}

struct Arrows {
  Lines used, left_out;
};

void add_arrow(Lines& lines, const Place& from, const Eigen::Vector2d& residual, double scale) {
  const Place to{from.x + scale * residual.x(), from.y + scale * residual.y()};
  lines.parts.push_back({from, to});
}

Arrows arrows_of(const CalibrationResult& result, const Panel& panel, std::size_t view, double scale) {
  Arrows arrows;
  const auto& corners = result.views[view].corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Place at = panel.at(corners[i].pixel.x(), corners[i].pixel.y());
    const bool used = result.fit.views[view].used[i] != 0;
    Eigen::Vector2d residual = result.fit.views[view].residuals[i];
    const double most = 2 * kArrowPx / scale;
    if (residual.norm() > most) residual *= most / residual.norm();
    add_arrow(used ? arrows.used : arrows.left_out, at, residual, scale);
  }
  arrows.used.stroke = Stroke{kBlue, 1};
  arrows.left_out.stroke = Stroke{kVermilion, 1.4};
  arrows.used.clip = arrows.left_out.clip = panel.area;
  return arrows;
}

void draw_dots(Scene& scene, const Panel& panel, const std::vector<Place>& places, const Colour& colour, double size) {
  Lines dots;
  for (const Place& place : places) dots.parts.push_back({place});
  dots.stroke = Stroke{colour, size};
  dots.clip = panel.area;
  scene.add(std::move(dots));
}

std::string arrow_words(double length) { return "the line in the legend is as long as " + formatted("%g px", length); }

void draw_arrow_legend(Scene& scene, const Panel& panel, double length, double scale) {
  const double y = 56;
  const double right = panel.area.right(), left = right - scale * length;
  scene.line({left, y}, {right, y}, {kBlue, 1.6});
  scene.add(Text{{left - 6, y + 4}, formatted("%g px", length), 11, Anchor::kEnd, kInk});
}

}  // namespace

Figure corners_figure(const CalibrationResult& result, std::size_t view, const GrayImage& image) {
  const Panel panel = image_panel(result, 0);
  Figure figure{"corners", {}, scene_for(panel)};
  const bundle::ViewFit& fit = result.fit.views[view];
  draw_heading(figure.scene, result.views[view].name,
               formatted("%zu corners, %.3f px rms", result.views[view].corners.size(), fit.rms_px));
  Image picture{panel.area, image.width, image.height, {}};
  // Halves the pixels until a page can carry it.
  int step = 1;
  while (image.width / step > 1000) ++step;
  picture.width = image.width / step;
  picture.height = image.height / step;
  picture.rgb.reserve(static_cast<std::size_t>(3 * picture.width * picture.height));
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u) {
      int sum = 0;
      for (int dv = 0; dv < step; ++dv)
        for (int du = 0; du < step; ++du) sum += image.view().row(v * step + dv)[u * step + du];
      // Half-way to white: what is drawn on it must be seen.
      const auto level = static_cast<std::uint8_t>(90 + sum / (step * step) * 165 / 255);
      picture.rgb.insert(picture.rgb.end(), {level, level, level});
    }
  draw_panel(figure.scene, panel, pixel_labels(""));
  figure.scene.add(std::move(picture));
  const double length = round_length(3 * result.fit.rms_px), scale = 0.5 * kArrowPx / length;
  Arrows arrows = arrows_of(result, panel, view, scale);
  std::vector<Place> good, bad;
  for (std::size_t i = 0; i < fit.used.size(); ++i) {
    const auto& pixel = result.views[view].corners[i].pixel;
    (fit.used[i] != 0 ? good : bad).push_back(panel.at(pixel.x(), pixel.y()));
  }
  draw_dots(figure.scene, panel, good, kGreen, 5);
  draw_dots(figure.scene, panel, bad, kVermilion, 7);
  figure.scene.add(std::move(arrows.used));
  figure.scene.add(std::move(arrows.left_out));
  finish_panel(figure.scene, panel, pixel_labels(""));
  draw_legend(figure.scene, {kLeftMargin, 56},
              {{"corner", {kGreen, 5}}, {"left out", {kVermilion, 5}}, {"projected minus seen", {kBlue, 1.6}}});
  draw_arrow_legend(figure.scene, panel, length, scale);
  figure.caption =
      "Corners that were found, and how far the calibration projects them from there; " + arrow_words(length) + ".";
  return figure;
}

Figure residual_figure(const CalibrationResult& result) {
  const Panel panel = image_panel(result, 0);
  Figure figure{"residuals", {}, scene_for(panel)};
  draw_heading(
      figure.scene, "Residuals over the image",
      formatted("%d corners in %zu views, %.3f px rms per axis", result.fit.used, result.views.size(), result.fit.rms_px));
  draw_panel(figure.scene, panel, pixel_labels(""));
  const double length = round_length(3 * result.fit.rms_px), scale = 0.5 * kArrowPx / length;
  for (std::size_t view = 0; view < result.views.size(); ++view) {
    Arrows arrows = arrows_of(result, panel, view, scale);
    figure.scene.add(std::move(arrows.used));
    figure.scene.add(std::move(arrows.left_out));
  }
  finish_panel(figure.scene, panel, pixel_labels(""));
  draw_legend(figure.scene, {kLeftMargin, 56}, {{"projected minus seen", {kBlue, 1.6}}, {"left out", {kVermilion, 1.6}}});
  draw_arrow_legend(figure.scene, panel, length, scale);
  figure.caption = "Residuals of all views where they lie in the image; " + arrow_words(length) +
                   ". Arrows that point the same way in one part of the image, view after view, would be a lens that the model "
                   "does not have.";
  return figure;
}

Figure uncertainty_figure(const CalibrationResult& result) {
  const Panel panel = image_panel(result, kBarRoom);
  Figure figure{"uncertainty", {}, scene_for(panel)};
  const bundle::UncertaintyMap& map = result.maps.front();
  draw_heading(figure.scene, "How well the calibration says where a point is seen", formatted("at %.0f mm", map.distance_mm));
  double low = 1e9, high = 0;
  for (const double x : map.worst_px) {
    if (!std::isfinite(x)) continue;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  const Scale colours{std::log10(low), std::log10(std::max(high, 1.001 * low))};
  Image picture{panel.area, map.columns, map.rows, {}};
  for (const double x : map.worst_px) {
    const Colour c = std::isfinite(x) ? viridis(colours.part(std::log10(x))) : kWhite;
    picture.rgb.insert(picture.rgb.end(), {c.red, c.green, c.blue});
  }
  draw_panel(figure.scene, panel, pixel_labels(""));
  figure.scene.add(std::move(picture));
  Eigen::MatrixXd heights(map.rows, map.columns);
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column)
      heights(row, column) = std::isfinite(map.at(row, column)) ? map.at(row, column) : high;
  for (double level = std::pow(10, std::floor(colours.low)); level < high; level *= 10)
    for (const double step : {1.0, 2.0, 5.0}) {
      if (step * level <= low || step * level >= high) continue;
      Lines lines;
      for (auto part : contour_lines(heights, step * level)) {
        for (Place& place : part)
          place = {panel.area.x + place.x / (map.columns - 1) * panel.area.width,
                   panel.area.y + place.y / (map.rows - 1) * panel.area.height};
        if (part.size() > 8) {
          const Place at = part[part.size() / 3];
          figure.scene.add(Text{{at.x, at.y - 3}, formatted("%g px", step * level), 10, Anchor::kMiddle, kWhite, true});
        }
        lines.parts.push_back(std::move(part));
      }
      lines.stroke = Stroke{faded(kWhite, 0.9), 1.2};
      lines.clip = panel.area;
      figure.scene.add(std::move(lines));
    }
  std::vector<Place> seen;
  for (const auto& view : result.views)
    for (const auto& corner : view.corners) seen.push_back(panel.at(corner.pixel.x(), corner.pixel.y()));
  draw_dots(figure.scene, panel, seen, faded(kBlack, 0.45), 2);
  finish_panel(figure.scene, panel, pixel_labels(""));
  // The colours' scale.
  const Rectangle bar{panel.area.right() + kBarGap, panel.area.y, kBarWidth, panel.area.height};
  Image scale{bar, 1, 64, {}};
  for (int i = 0; i < 64; ++i) {
    const Colour c = viridis(1 - (i + 0.5) / 64);
    scale.rgb.insert(scale.rgb.end(), {c.red, c.green, c.blue});
  }
  figure.scene.add(std::move(scale));
  for (const double part : {0.0, 0.5, 1.0}) {
    const double value = std::pow(10, colours.low + part * (colours.high - colours.low));
    figure.scene.add(
        Text{{bar.right() + 5, bar.bottom() - part * bar.height + 4}, formatted("%.2g px", value), 11, Anchor::kStart, kInk});
  }
  draw_legend(figure.scene, {kLeftMargin, 56},
              {{"corner of a view", {kFaintInk, 3}}, {"line of equal deviation", {kGrid, 1.6}}});
  figure.caption = formatted(
      "Standard deviation, along its worst direction, of where a point %.0f mm away is seen: what errors of lens, poses and "
      "board "
      "leave once a later pose has taken up what a turn and a shift can.",
      map.distance_mm);
  return figure;
}

Figure views_figure(const CalibrationResult& result) {
  const std::size_t n = result.views.size();
  const double height = 150;
  Figure figure{"views", {}, Scene(kFigureWidth, kTop + 2 * height + 120)};
  draw_heading(figure.scene, "Views", formatted("%zu", n));
  double most_rms = 0, most_share = 0;
  for (const auto& view : result.fit.views) {
    most_rms = std::max(most_rms, view.rms_px);
    most_share = std::max(most_share, 100 * view.share);
  }
  for (const bool share : {false, true}) {
    const Rectangle area{kLeftMargin, kTop + (share ? height + 56 : 0), kFigureWidth - kLeftMargin - kRightMargin, height};
    const Panel panel{area, {0.3, static_cast<double>(n) + 0.7}, {0, 1.1 * (share ? most_share : most_rms)}};
    const PanelLabels labels{.title = share ? "Share of what all views say" : "Residuals",
                             .x_label = "view",
                             .y_label = share ? "%" : "px rms",
                             .x_unit = "",
                             .y_unit = share ? "%" : "px",
                             .most_x_ticks = 20,
                             .most_y_ticks = 5};
    draw_panel(figure.scene, panel, labels);
    for (std::size_t i = 0; i < n; ++i) {
      const double value = share ? 100 * result.fit.views[i].share : result.fit.views[i].rms_px;
      const Place top = panel.at(static_cast<double>(i) + 0.7, value), foot = panel.at(static_cast<double>(i) + 1.3, 0);
      figure.scene.box({top.x, top.y, foot.x - top.x, foot.y - top.y}, faded(kBlue, 0.8));
    }
    finish_panel(figure.scene, panel, labels);
  }
  figure.caption = "Residuals of each view per axis, and how much of the information on lens and board is its own.";
  return figure;
}

GrayImage undistorted(const GrayImage& image, const bundle::CameraFit& fit) {
  GrayImage out{std::vector<std::uint8_t>(image.pixels.size(), 0), image.width, image.height};
  const std::vector<double>& k = fit.intrinsics;
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      Eigen::Vector2d raw;
      if (!bundle::project(k, {(u - k[2]) / k[0], (v - k[3]) / k[1], 1}, raw)) continue;
      if (!(raw.x() >= 0 && raw.y() >= 0 && raw.x() <= image.width - 1.001 && raw.y() <= image.height - 1.001)) continue;
      const int u0 = static_cast<int>(raw.x()), v0 = static_cast<int>(raw.y());
      const double du = raw.x() - u0, dv = raw.y() - v0;
      const std::uint8_t* upper = image.view().row(v0) + u0;
      const std::uint8_t* lower = image.view().row(std::min(v0 + 1, image.height - 1)) + u0;
      const double level = (1 - dv) * ((1 - du) * upper[0] + du * upper[1]) + dv * ((1 - du) * lower[0] + du * lower[1]);
      out.pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(u)] =
          static_cast<std::uint8_t>(std::lround(level));
    }
  return out;
}

}  // namespace srd::host
