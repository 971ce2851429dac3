// SPDX-License-Identifier: Apache-2.0
// Scenes with known truth: views round a tank, a pattern on its bottom, a surface, and the pixels that follow exactly.
#pragma once

#include <array>
#include <cassert>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "dsp/estimate/residual/observation.hpp"
#include "dsp/optics/ray_trace.hpp"

namespace srd::fakes {

using dsp::CameraModel;
using dsp::Coefficients;
using dsp::Mat2;
using dsp::Mat3;
using dsp::Media;
using dsp::ModeList;
using dsp::Observation;
using dsp::SurfaceModel;
using dsp::Vec2;
using dsp::Vec3;
using dsp::View;

inline constexpr double kPi = 3.14159265358979323846;

// A camera at centre that looks at target, with +Y of the world to the right of its image.
inline View<double> look_at(const CameraModel<double>& camera, const Vec3<double>& centre, const Vec3<double>& target) {
  const Vec3<double> z = (target - centre).normalized();
  const Vec3<double> along = Vec3<double>::UnitY();
  const Vec3<double> x = (along - along.dot(z) * z).normalized();
  const Vec3<double> y(z.y() * x.z() - z.z() * x.y(), z.z() * x.x() - z.x() * x.z(), z.x() * x.y() - z.y() * x.x());
  View<double> view;
  view.camera = camera;
  view.pose.rotation << x.transpose(), y.transpose(), z.transpose();
  view.pose.translation = -(view.pose.rotation * centre);
  return view;
}

// Corners of a checkerboard on the bottom: X = row square, Y = column square, Z = 0, row by row.
inline std::vector<Vec3<double>> pattern_points(int rows, int columns, double square_mm) {
  std::vector<Vec3<double>> points;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) points.emplace_back(row * square_mm, column * square_mm, 0.0);
  return points;
}

inline Coefficients<double> coefficients(std::initializer_list<double> list) {
  Coefficients<double> a(static_cast<Eigen::Index>(list.size()));
  std::copy(list.begin(), list.end(), a.data());
  return a;
}

// The published prefixes with a level of 80 mm and modes of a few mm.
inline Coefficients<double> wavy(int parameters, double level_mm = 80) {
  static constexpr std::array<double, 24> kModes{0,    1.4, -2.1, 3.0, -2.6, 1.7, 2.2,  -1.9, 0.5,  -0.8, 0.9,  -1.1,
                                                 -0.4, 0.3, 0.5,  0.2, -0.3, 0.4, -0.2, 0.25, 0.15, -0.1, 0.12, 0.1};
  Coefficients<double> a(parameters);
  for (int i = 0; i < parameters; ++i) a[i] = kModes[static_cast<std::size_t>(i)];
  a[0] = level_mm;
  return a;
}

// A level surface with as many parameters.
inline Coefficients<double> level(int parameters, double height_mm) {
  Coefficients<double> a = Coefficients<double>::Zero(parameters);
  a[0] = height_mm;
  return a;
}

struct Scene {
  std::vector<View<double>> views;
  std::vector<Vec3<double>> points;
  SurfaceModel<double> model;
  Media<double> media;
  Coefficients<double> truth;

  [[nodiscard]] int parameters() const { return model.modes.size(); }

  // Normalised coordinates at which a view sees a point through the true surface.
  [[nodiscard]] Vec2<double> seen(std::size_t view, const Vec3<double>& point) const {
    dsp::Trace<double> trace;
    Mat2<double> b_xy;
    const auto start = views[view].normalised(point);
    const auto xy = dsp::see_through(views[view], model, truth, media, point, start.value(), trace, b_xy);
    assert(xy.ok());
    return xy.value();
  }

  // All corners of a view, exact but for Gaussian noise of noise_px an axis.
  template <class S>
  [[nodiscard]] std::vector<Observation<S>> observe(std::size_t view, double noise_px = 0,
                                                    std::mt19937_64* random = nullptr) const {
    std::vector<Observation<S>> out;
    std::normal_distribution<double> normal(0, 1);
    for (std::size_t i = 0; i < points.size(); ++i) {
      Vec2<double> pixel = views[view].camera.pixel(seen(view, points[i]));
      if (random != nullptr)
        for (double& coordinate : pixel) coordinate += noise_px * normal(*random);
      Observation<S> seen_corner;
      seen_corner.point = static_cast<int>(i);
      seen_corner.pixel = pixel.template cast<S>();
      // As on the board: undistorted in the scalar of the estimate.
      const auto xy = views[view].camera.template cast<S>().undistort(seen_corner.pixel);
      assert(xy.ok());
      seen_corner.normalised = *xy;
      seen_corner.sigma = noise_px > 0 ? static_cast<S>(noise_px) : S(1);
      out.push_back(seen_corner);
    }
    return out;
  }

  // rms of the difference of two surfaces over the pattern, mm.
  template <class S>
  [[nodiscard]] double surface_error(const Coefficients<S>& a) const {
    const Coefficients<double> wide = a.template cast<double>();
    double sum = 0;
    for (const Vec3<double>& point : points) {
      const double e = model.height(wide, point.x(), point.y()) - model.height(truth, point.x(), point.y());
      sum += e * e;
    }
    return std::sqrt(sum / static_cast<double>(points.size()));
  }
};

// The camera of the flume: 1280 x 640 px.
inline CameraModel<double> flume_camera() {
  const std::array<double, 5> distortion{-0.21, 0.09, -0.004, -0.0035, 0.3};
  return CameraModel<double>::make(2150, 2150, 648, 315, distortion).value();
}

// Cameras round the tank, 0.95 m off and 25 degrees from the vertical; 11 x 21 corners of 20 mm.
inline Scene flume_scene(int parameters, int cameras) {
  Scene scene;
  scene.points = pattern_points(11, 21, 20);
  for (int i = 0; i < cameras; ++i) {
    const double azimuth = kPi * (20 + 120 * i) / 180, off = 950, tilt = 25 * kPi / 180;
    const Vec3<double> target(100, 200, 0);
    const Vec3<double> centre =
        target + off * Vec3<double>(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
    scene.views.push_back(look_at(flume_camera(), centre, target));
  }
  scene.model.modes = ModeList::standard(parameters).value();
  scene.model.lx = 240;
  scene.model.ly = 440;
  scene.truth = wavy(parameters);
  return scene;
}

}  // namespace srd::fakes
