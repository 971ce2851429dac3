// SPDX-License-Identifier: Apache-2.0
#include "host/study/surface_study.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <random>

#include "drivers/camera/simulator/renderer.hpp"
#include "dsp/pipeline/surface_tracker.hpp"
#include "host/study/lower_bound.hpp"

namespace srd::study {

namespace {

constexpr double kNoisePx = 0.1;
constexpr std::array<int, 5> kModels{1, 3, 5, 8, 12};
constexpr int kMaxCameras = 3;

// One tank, as each of its cameras sees it: 18 degrees off the vertical, a third of a turn apart.
std::vector<Scene> tank_scenes(int parameters, int cameras) {
  std::vector<Scene> scenes;
  for (int i = 0; i < cameras; ++i) {
    Scene scene = default_scene();
    scene.surface.modes = dsp::ModeList::standard(parameters).value();
    scene.motions.clear();
    for (int j = 0; j < parameters; ++j)
      scene.motions.push_back({scene.surface.modes[j], j == 0 ? 80.0 : 0.0, j < 5 ? 3.0 : 1.0, 0.4 + 0.17 * j, 0.7 + 1.9 * j});
    const double azimuth = M_PI * (200 + 120 * i) / 180, tilt = M_PI / 10, off = 960;
    const dsp::Vec3<double> target(100, 200, 0);
    scene.pose = look_at(target + off * dsp::Vec3<double>(std::sin(tilt) * std::cos(azimuth),
                                                          std::sin(tilt) * std::sin(azimuth), std::cos(tilt)),
                         target, 0)
                     .value();
    scene.seed = static_cast<std::uint64_t>(1 + i);
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

struct Case {
  std::vector<Scene> scenes;
  std::vector<dsp::View<double>> views;
  Points points;
  Tank tank;

  Case(int parameters, int cameras) : scenes(tank_scenes(parameters, cameras)), points(scenes[0].points()) {
    for (const Scene& scene : scenes) views.push_back(scene.view());
    tank = {views, points, scenes[0].surface, scenes[0].media};
  }
  [[nodiscard]] dsp::Coefficients<double> start() const {
    dsp::Coefficients<double> a = dsp::Coefficients<double>::Zero(tank.model.modes.size());
    a[0] = 80;
    return a;
  }
  // mm^2; sigma of a corner in each view.
  [[nodiscard]] double bound_squared(const dsp::Coefficients<double>& truth, double sigma_px) const {
    dsp::InformationMatrix<double> sum = information_bound(tank, 0, truth, sigma_px).value();
    for (std::size_t view = 1; view < views.size(); ++view) sum += information_bound(tank, view, truth, sigma_px).value();
    return std::pow(surface_bound(tank, sum).value(), 2);
  }
};

SurfaceRow from_features(int parameters, int cameras, int draws) {
  Case c(parameters, cameras);
  auto estimator =
      dsp::SurfaceEstimator<double>::make(c.tank.model, c.tank.media, c.points, {}, cameras * static_cast<int>(c.points.size()))
          .value();
  std::mt19937_64 random(static_cast<std::uint64_t>(100 * parameters + cameras));
  std::normal_distribution<double> normal(0, kNoisePx);
  const dsp::Coefficients<double> truth = c.scenes[0].coefficients(0), start = c.start();
  std::vector<std::vector<dsp::Vec2<double>>> exact;
  for (const Scene& scene : c.scenes) exact.push_back(truth_pixels(scene, 0).value());
  SurfaceRow row{SurfaceSource::kFeatures, parameters, cameras, draws};
  double squares = 0;
  for (int draw = 0; draw < draws; ++draw) {
    std::vector<std::vector<dsp::Observation<double>>> corners(c.views.size());
    std::vector<dsp::CameraObservations<double>> seen;
    for (std::size_t view = 0; view < c.views.size(); ++view) {
      for (std::size_t i = 0; i < c.points.size(); ++i) {
        dsp::Observation<double> corner;
        corner.point = static_cast<int>(i);
        const double du = normal(random), dv = normal(random);
        corner.pixel = exact[view][i] + dsp::Vec2<double>(du, dv);
        const auto undistorted = c.views[view].camera.undistort(corner.pixel);
        if (!undistorted) continue;
        corner.normalised = *undistorted;
        corner.sigma = kNoisePx;
        corners[view].push_back(corner);
      }
      seen.push_back({&c.views[view], corners[view]});
    }
    const auto found = estimator.estimate(seen, std::span(&start, 1));
    if (dsp::failed(found.stop)) continue;
    ++row.surfaces;
    squares += std::pow(surface_error(c.tank, found.coefficients, truth), 2);
  }
  row.corner_px = kNoisePx;
  row.surface_mm = std::sqrt(squares / row.surfaces);
  row.bound_mm = std::sqrt(c.bound_squared(truth, kNoisePx));
  return row;
}

Outcome<SurfaceRow> from_images(int parameters, int cameras, int frames) {
  Case c(parameters, cameras);
  std::vector<Renderer> renderers;
  std::vector<dsp::CameraSetup<double>> setups;
  std::vector<GrayImage> images;
  for (const Scene& scene : c.scenes) {
    auto renderer = Renderer::make(scene);
    if (!renderer) return renderer.error();
    renderers.push_back(std::move(*renderer));
    setups.push_back({scene.view(), scene.width(), scene.height(), {}});
    images.push_back(
        {std::vector<std::uint8_t>(static_cast<std::size_t>(scene.width() * scene.height())), scene.width(), scene.height()});
  }
  auto tracker = dsp::SurfaceTracker<double>::make(setups, dsp::Pattern::make(c.points, dsp::FirstSquare::kDark).value(),
                                                   c.tank.model, c.tank.media, c.start(), {}, {})
                     .value();
  SurfaceRow row{SurfaceSource::kImages, parameters, cameras, frames};
  double squares = 0, bounds = 0, corner_squares = 0, corners = 0;
  std::vector<dsp::Coefficients<double>> truths;
  for (int k = 0; k < frames; ++k) {
    const auto frame = static_cast<std::uint64_t>(k);
    std::vector<GrayView> views;
    for (std::size_t i = 0; i < images.size(); ++i) {
      renderers[i].render(frame, {images[i].pixels.data(), images[i].width, images[i].height, images[i].width});
      views.push_back(images[i].view());
    }
    const auto& result = tracker.process(views, c.scenes[0].time_ns(frame));
    if (!result.has_surface()) continue;
    ++row.surfaces;
    const auto truth = c.scenes[0].coefficients(frame);
    squares += std::pow(surface_error(c.tank, result.estimate.coefficients, truth), 2);
    truths.push_back(truth);
    for (std::size_t i = 0; i < images.size(); ++i) {
      const auto exact = truth_pixels(c.scenes[i], frame).value();
      for (const auto& corner : result.observations[i]) {
        corner_squares += (corner.pixel - exact[static_cast<std::size_t>(corner.point)]).squaredNorm();
        ++corners;
      }
    }
  }
  if (row.surfaces == 0)
    return Problem{Exit::kInput, "no frame gave a surface", std::to_string(parameters) + " parameters", "", "", ""};
  row.corner_px = std::sqrt(corner_squares / (2 * corners));
  row.surface_mm = std::sqrt(squares / row.surfaces);
  for (const auto& truth : truths) bounds += c.bound_squared(truth, row.corner_px);
  row.bound_mm = std::sqrt(bounds / row.surfaces);
  return row;
}

}  // namespace

Outcome<std::vector<SurfaceRow>> study_surfaces(bool quick, const Progress& progress) {
  std::vector<SurfaceRow> rows;
  const auto wanted = [&](int model) { return !quick || model == 1 || model == 5; };
  int all = 0, done = 0;
  for (const int model : kModels) all += kMaxCameras * (wanted(model) ? 2 : 1);
  const auto step = [&] {
    if (progress) progress(++done, all);
  };
  for (int cameras = 1; cameras <= kMaxCameras; ++cameras)
    for (const int model : kModels) {
      rows.push_back(from_features(model, cameras, quick ? 20 : 1000));
      step();
    }
  for (int cameras = 1; cameras <= kMaxCameras; ++cameras)
    for (const int model : kModels) {
      if (!wanted(model)) continue;
      auto row = from_images(model, cameras, quick ? 3 : 50);
      if (!row) return row.error();
      rows.push_back(*row);
      step();
    }
  return rows;
}

}  // namespace srd::study
