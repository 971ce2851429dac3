// SPDX-License-Identifier: Apache-2.0
#include "host/study/study_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/plot/axis.hpp"
#include "host/plot/mode_panels.hpp"
#include "host/plot/palette.hpp"

namespace srd::study {

namespace {

using host::Colour;
using host::Lines;
using host::Panel;
using host::PanelLabels;
using host::Rectangle;
using host::Stroke;

constexpr double kDot = 6;

void draw_dots(host::Scene& scene, const Panel& panel, const std::vector<double>& x, const std::vector<double>& y,
               const Colour& colour) {
  Lines dots;
  for (std::size_t i = 0; i < x.size(); ++i) dots.parts.push_back({panel.at(x[i], y[i])});
  dots.stroke = Stroke{colour, kDot};
  dots.clip = panel.area;
  scene.add(std::move(dots));
}

void draw_line(host::Scene& scene, const Panel& panel, const std::vector<double>& x, const std::vector<double>& y,
               const Stroke& stroke, const char* role = "") {
  host::draw_series(scene, panel, x, y, {{0, x.size()}}, stroke, role);
}

struct Series {
  double CornerRow::*value;
  Stroke stroke;
  bool dots;
};

void draw_corner_panel(host::Scene& scene, const Rectangle& area, const std::vector<CornerRow>& rows, const std::string& varied,
                       const std::string& title, const std::string& unit) {
  static const std::array<Series, 4> all{{{&CornerRow::bound_px, {host::kBlack, 1.2}, false},
                                          {&CornerRow::stated_px, {host::kGreen, 1.6}, false},
                                          {&CornerRow::opencv_px, {host::kVermilion, 1.2}, true},
                                          {&CornerRow::rms_px, {host::kBlue, 1.6}, true}}};
  std::vector<double> x;
  std::array<std::vector<double>, all.size()> y;
  for (const CornerRow& row : rows) {
    if (row.varied != varied) continue;
    x.push_back(row.value());
    for (std::size_t i = 0; i < all.size(); ++i) y[i].push_back(row.*all[i].value);
  }
  const double room = 0.05 * (x.back() - x.front());
  const Panel panel{area, {x.front() - room, x.back() + room}, {0.001, 0.15, true}};
  const PanelLabels labels{
      .title = title, .x_label = title + ", " + unit, .y_label = "px rms per axis", .x_unit = unit, .y_unit = "px"};
  host::draw_panel(scene, panel, labels);
  for (std::size_t i = 0; i < all.size(); ++i) {
    draw_line(scene, panel, x, y[i], all[i].stroke, all[i].dots ? "series" : "");
    if (all[i].dots) draw_dots(scene, panel, x, y[i], all[i].stroke.colour);
  }
  host::finish_panel(scene, panel, labels);
}

void draw_surface_panel(host::Scene& scene, const Rectangle& area, const std::vector<SurfaceRow>& rows, SurfaceSource source,
                        const std::string& title) {
  static constexpr std::array<Colour, 3> kColours{host::kBlue, host::kVermilion, host::kGreen};
  double most = 0;
  for (const SurfaceRow& row : rows)
    if (row.source == source) most = std::max({most, row.surface_mm, row.bound_mm});
  const Panel panel{area, {0, 13}, {0, 1.1 * most}};
  const PanelLabels labels{.title = title,
                           .x_label = "parameters of the surface",
                           .y_label = "mm rms over the pattern",
                           .x_unit = "parameters",
                           .y_unit = "mm"};
  host::draw_panel(scene, panel, labels);
  for (int cameras = 1; cameras <= 3; ++cameras) {
    std::vector<double> x, measured, bound;
    for (const SurfaceRow& row : rows) {
      if (row.source != source || row.cameras != cameras) continue;
      x.push_back(row.parameters);
      measured.push_back(row.surface_mm);
      bound.push_back(row.bound_mm);
    }
    const Colour& colour = kColours[static_cast<std::size_t>(cameras - 1)];
    draw_line(scene, panel, x, bound, {colour, 1.2}, "series");
    draw_dots(scene, panel, x, measured, colour);
  }
  host::finish_panel(scene, panel, labels);
}

}  // namespace

host::Figure corner_figure(const std::vector<CornerRow>& rows) {
  constexpr double kLeft = 78, kWide = 380, kHigh = 210, kTop = 84;
  host::Figure figure{"corners", {}, host::Scene(host::kFigureWidth, kTop + 2 * kHigh + 116)};
  host::draw_heading(figure.scene, "Error of a corner", "rendered boards, against the truth");
  host::draw_legend(figure.scene, {kLeft, 46},
                    {{"measured", {host::kBlue, 1.6}},
                     {"stated by the corner", {host::kGreen, 1.6}},
                     {"lower bound", {host::kBlack, 1.2}},
                     {"cv::cornerSubPix, best window", {host::kVermilion, 1.2}}});
  static const std::array<std::array<const char*, 3>, 4> panels{{{"blur_px", "Blur", "px"},
                                                                 {"noise", "Noise", "grey levels"},
                                                                 {"contrast", "Contrast", "grey levels"},
                                                                 {"square_px", "Square", "px"}}};
  for (std::size_t i = 0; i < panels.size(); ++i)
    draw_corner_panel(
        figure.scene,
        {kLeft + static_cast<double>(i % 2) * (kWide + 90), kTop + static_cast<double>(i / 2) * (kHigh + 72), kWide, kHigh},
        rows, panels[i][0], panels[i][1], panels[i][2]);
  figure.caption =
      "Error of a checkerboard corner per axis while one condition changes; the others stay at blur 0.9 px, noise 2 and "
      "contrast 200 grey levels, squares of 38 px. The lower bound (20) is for square-on edges, a window of 11 px and "
      "known levels and blur. cv::cornerSubPix starts at the pixels nearest to the truth and has the window that is best "
      "for these very images.";
  return figure;
}

host::Figure surface_figure(const std::vector<SurfaceRow>& rows) {
  constexpr double kLeft = 78, kWide = 380, kHigh = 300, kTop = 84;
  host::Figure figure{"surface", {}, host::Scene(host::kFigureWidth, kTop + kHigh + 50)};
  host::draw_heading(figure.scene, "Error of the surface", "dots: measured; lines: lower bound");
  host::draw_legend(
      figure.scene, {kLeft, 46},
      {{"1 camera", {host::kBlue, 1.6}}, {"2 cameras", {host::kVermilion, 1.6}}, {"3 cameras", {host::kGreen, 1.6}}});
  draw_surface_panel(figure.scene, {kLeft, kTop, kWide, kHigh}, rows, SurfaceSource::kFeatures,
                     "True corners with 0.1 px noise");
  draw_surface_panel(figure.scene, {kLeft + kWide + 90, kTop, kWide, kHigh}, rows, SurfaceSource::kImages,
                     "Whole chain, from images");
  figure.caption =
      "Error of the surface over the pattern: 231 corners of 20 mm under 80 mm of water, cameras 0.96 m off and 18 "
      "degrees from the vertical. Lines: the least error that any unbiased estimate can have (19), from images at the "
      "deviation that their corners were measured to have.";
  return figure;
}

}  // namespace srd::study
