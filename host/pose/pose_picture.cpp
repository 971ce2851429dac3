// SPDX-License-Identifier: Apache-2.0
#include "host/pose/pose_picture.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "host/plot/palette.hpp"

namespace srd::host {

namespace {

constexpr double kPictureWidth = 960, kHeadRoom = 46, kSideRoom = 40, kMapRoom = 60;
constexpr int kIdEvery = 5;
constexpr double kArrowOfCell = 0.6;  // length of the rms residual, of the spacing of corners

Lines cross_at(Place at, double size, const Colour& colour) {
  return Lines{.parts = {{{at.x - size, at.y}, {at.x + size, at.y}}, {{at.x, at.y - size}, {at.x, at.y + size}}},
               .stroke = Stroke{colour, 1.0}};
}

// 1, 2 or 5 times a power of ten, not above x.
double round_down(double x) {
  const double power = std::pow(10, std::floor(std::log10(x)));
  for (const double step : {5.0, 2.0})
    if (step * power <= x) return step * power;
  return power;
}

double rms_of(const std::vector<dsp::Vec2<double>>& vectors) {
  double sum = 0;
  for (const auto& v : vectors) sum += v.squaredNorm();
  return std::sqrt(std::max(1e-18, sum / static_cast<double>(std::max<std::size_t>(1, vectors.size()))));
}

void add_scale(Scene& scene, double units_per_one, double rms, const char* unit, Place at) {
  const double shown = round_down(3 * rms);
  scene.line(at, {at.x + shown * units_per_one, at.y}, Stroke{kVermilion, 2.0});
  scene.add(Text{.at = {at.x + shown * units_per_one + 6, at.y + 4},
                 .text = formatted("%g ", shown) + unit + formatted(" left (rms %.3g ", rms) + unit + ")",
                 .size = 12,
                 .colour = kInk});
}

Image grey_image(const GrayView& image, const Rectangle& over) {
  Image out{over, image.width, image.height, {}};
  out.rgb.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      // Half the contrast, so that what is drawn over it can be seen.
      const auto level = static_cast<std::uint8_t>(90 + image.row(v)[u] / 2);
      out.rgb.insert(out.rgb.end(), {level, level, level});
    }
  return out;
}

bool has_id(int place, PatternSize board) {
  const int row = place / board.columns, column = place % board.columns;
  const bool corner = (row == 0 || row == board.rows - 1) && (column == 0 || column == board.columns - 1);
  return corner || (row % kIdEvery == 0 && column % kIdEvery == 0);
}

}  // namespace

Scene overlay_picture(const MeasuredPose& pose, const dsp::WaterAbove* water) {
  const GrayView image = pose.view.image.view();
  const double scale = kPictureWidth / image.width;
  Scene scene(kPictureWidth, kHeadRoom + scale * image.height);
  const auto place = [&](const dsp::Vec2<double>& pixel) {
    return Place{scale * (pixel.x() + 0.5), kHeadRoom + scale * (pixel.y() + 0.5)};
  };
  scene.add(grey_image(image, {0, kHeadRoom, kPictureWidth, scale * image.height}));
  const auto& corners = pose.view.corners;
  const double cell = scale * (corners[1].pixel - corners[0].pixel).norm();
  const double rms = rms_of(pose.fit.left_px), magnified = kArrowOfCell * cell / rms;

  const dsp::View<double> view{pose.calibration.camera, pose.fit.pose};
  const auto seen = [&](const dsp::Vec3<double>& point) { return dsp::see_point(view, point, water); };
  const dsp::Vec3<double> origin = pose.points.front();
  const double length = 2 * pose.square_mm;
  const std::pair<dsp::Vec3<double>, const char*> axes[] = {
      {{length, 0, 0}, "X"}, {{0, length, 0}, "Y"}, {{0, 0, length}, "Z"}};
  const Colour colours[] = {kVermilion, kGreen, kBlue};
  const auto foot = seen(origin);
  for (std::size_t i = 0; foot && i < 3; ++i) {
    // Z stands out of water: drawn as in air.
    const auto tip = i == 2 ? dsp::see_point(view, origin + axes[i].first, nullptr) : seen(origin + axes[i].first);
    if (!tip) continue;
    const Place end = place(tip->pixel);
    scene.line(place(foot->pixel), end, Stroke{colours[i], 3.0});
    scene.add(Text{.at = {end.x + 4, end.y + 4}, .text = axes[i].second, .size = 15, .colour = colours[i], .bold = true});
  }
  Lines arrows{.parts = {}, .stroke = Stroke{kVermilion, 1.2}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Place at = place(corners[i].pixel);
    scene.add(cross_at(at, std::min(3.0, 0.15 * cell), kBlue));
    const dsp::Vec2<double> arrow = magnified * pose.fit.left_px[i];
    arrows.parts.push_back({at, {at.x + arrow.x(), at.y + arrow.y()}});
    const int id = pose.order.points[i];
    if (has_id(id, pose.board))
      scene.add(Text{.at = {at.x + 3, at.y - 3}, .text = std::to_string(id), .size = 10, .colour = kBlack, .bold = true});
  }
  scene.add(std::move(arrows));
  scene.box({0, 0, kPictureWidth, kHeadRoom}, kWhite);
  scene.add(Text{.at = {8, 18},
                 .text = formatted("%d corners, order from ", pose.fit.corners) + pose.order.how +
                         "; numbers: places in the pattern's list",
                 .size = 12,
                 .colour = kInk});
  add_scale(scene, magnified, rms, "px", {8, 34});
  return scene;
}

Scene residual_map(const MeasuredPose& pose, const std::vector<dsp::Vec2<double>>& left_mm) {
  dsp::Vec2<double> least = pose.points.front().head<2>(), most = least;
  for (const auto& p : pose.points) {
    least = least.cwiseMin(p.head<2>());
    most = most.cwiseMax(p.head<2>());
  }
  // The pattern's longer side to the right.
  const dsp::Vec2<double> extent = most - least;
  const bool turned = extent.x() > extent.y();
  const auto across = [turned](const dsp::Vec2<double>& v) { return turned ? v.x() : v.y(); };
  const auto down = [turned](const dsp::Vec2<double>& v) { return turned ? v.y() : v.x(); };
  const double scale = (kPictureWidth - 2 * kSideRoom) / std::max(1e-9, across(extent));
  Scene scene(kPictureWidth, 2 * kMapRoom + scale * down(extent));
  scene.box({0, 0, scene.width(), scene.height()}, kWhite);
  const double rms = rms_of(left_mm), magnified = kArrowOfCell * scale * pose.square_mm / rms;
  Lines arrows{.parts = {}, .stroke = Stroke{kVermilion, 1.2}}, dots{.parts = {}, .stroke = Stroke{kBlue, 1.0}};
  for (std::size_t i = 0; i < left_mm.size(); ++i) {
    const dsp::Vec2<double> p = pose.point_of(i).head<2>() - least;
    const Place at{kSideRoom + scale * across(p), kMapRoom + scale * down(p)};
    const auto dot = cross_at(at, 2, kBlue);
    dots.parts.insert(dots.parts.end(), dot.parts.begin(), dot.parts.end());
    arrows.parts.push_back({at, {at.x + magnified * across(left_mm[i]), at.y + magnified * down(left_mm[i])}});
  }
  scene.add(std::move(dots));
  scene.add(std::move(arrows));
  scene.add(Text{.at = {8, 18},
                 .text = std::string("Corners on the pattern as found, less where the list has them; ") +
                         (turned ? "X to the right, Y down" : "Y to the right, X down"),
                 .size = 12,
                 .colour = kInk});
  add_scale(scene, magnified, rms, "mm", {8, 34});
  return scene;
}

}  // namespace srd::host
