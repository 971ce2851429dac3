// SPDX-License-Identifier: Apache-2.0
// The whole chain over the frames of a scene, against its truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "drivers/camera/simulator/renderer.hpp"
#include "dsp/pipeline/surface_tracker.hpp"
#include "host/study/lower_bound.hpp"

namespace srd::accuracy {

struct FlumeRun {
  int frames = 0, surfaces = 0, lost = 0;  // lost: frames in which a track was not kept
  int wrong = 0;                           // corners more than a fifth of a square from their place
  double used_percent = 0;
  double corner_rms_px = 0;                     // per axis, of the corners used
  double corner_median_px = 0;                  // the deviation that their median error says: a few bad corners do not count
  double surface_rms_mm = 0, bound_rms_mm = 0;  // (19) at corner_median_px, with the corners used
  double opencv_rms_px = 0;                     // cornerSubPix at its best window, started at the nearest pixels of the truth
  int opencv_window = 0;
  double fastest_px = 0;  // largest move of a corner between two frames

  void print(const char* name) const {
    std::printf("%s: %d frames, %d lost, %d wrong corners, %.1f %% used; corners %.4f px rms, %.4f px by the median", name,
                frames, lost, wrong, used_percent, corner_rms_px, corner_median_px);
    if (opencv_window > 0) std::printf(" (cornerSubPix %.4f, window %d)", opencv_rms_px, opencv_window);
    std::printf("; surface %.4f mm, bound %.4f mm, ratio %.2f; corners move up to %.1f px a frame\n", surface_rms_mm,
                bound_rms_mm, surface_rms_mm / bound_rms_mm, fastest_px);
  }
};

// Squared errors of cv::cornerSubPix by half window, 2..16.
class OpencvCorners {
 public:
  void add(const GrayView& image, const std::vector<dsp::Vec2<double>>& truth) {
    const cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels),
                         static_cast<std::size_t>(image.stride_bytes));
    for (int window = kMin; window <= kMax; ++window) {
      std::vector<cv::Point2f> corners;
      for (const auto& at : truth)
        corners.emplace_back(static_cast<float>(std::round(at.x())), static_cast<float>(std::round(at.y())));
      cv::cornerSubPix(pixels, corners, {window, window}, {-1, -1},
                       {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-4});
      for (std::size_t i = 0; i < truth.size(); ++i) {
        const double du = static_cast<double>(corners[i].x) - truth[i].x();
        const double dv = static_cast<double>(corners[i].y) - truth[i].y();
        squares_[static_cast<std::size_t>(window)] += du * du + dv * dv;
      }
    }
    n_ += truth.size();
  }
  [[nodiscard]] int best_window() const {
    const auto first = squares_.begin() + kMin;
    return static_cast<int>(std::min_element(first, squares_.end()) - squares_.begin());
  }
  [[nodiscard]] double rms() const {
    return std::sqrt(squares_[static_cast<std::size_t>(best_window())] / (2 * static_cast<double>(n_)));
  }

 private:
  static constexpr int kMin = 2, kMax = 16;
  std::vector<double> squares_ = std::vector<double>(kMax + 1, 0.0);
  std::size_t n_ = 0;
};

// A camera whose image processor reduces its frames to half by area and sharpens them by an unsharp mask: the scene is what its
// sensor sees, in twice the size.
class HalvingCamera {
 public:
  explicit HalvingCamera(double amount, double radius_px = 1) : amount_(amount), radius_(radius_px) {}
  // The scene whose frames this camera delivers when its sensor sees a frame of 'scene' at twice the size.
  [[nodiscard]] static Scene at_twice_the_size(Scene scene) {
    const dsp::CameraModel<double> camera = scene.calibration.camera;
    // The middle of the first pixel is the middle of four.
    scene.calibration.camera = dsp::CameraModel<double>::make(2 * camera.fx(), 2 * camera.fy(), 2 * camera.cx() + 0.5,
                                                              2 * camera.cy() + 0.5, camera.distortion())
                                   .value();
    scene.calibration.image_width *= 2;
    scene.calibration.image_height *= 2;
    return scene;
  }
  void take(const std::vector<std::uint8_t>& sensor, const GrayView& image, std::vector<std::uint8_t>& pixels) const {
    const cv::Mat large(2 * image.height, 2 * image.width, CV_8U, const_cast<std::uint8_t*>(sensor.data()));
    cv::Mat exact, reduced, smooth;
    large.convertTo(exact, CV_32F);
    cv::resize(exact, reduced, {image.width, image.height}, 0, 0, cv::INTER_AREA);
    if (amount_ > 0) {
      cv::GaussianBlur(reduced, smooth, {0, 0}, radius_);
      reduced = reduced + amount_ * (reduced - smooth);
    }
    cv::Mat out(image.height, image.width, CV_8U, pixels.data());
    reduced.convertTo(out, CV_8U);
  }

 private:
  double amount_, radius_;
};

// guess: level, mm. The tracker works in S. opencv_frames: so many frames also go to cornerSubPix. camera: see there; noise
// is the sensor's then.
template <class S>
FlumeRun run_flume(const Scene& scene, int frames, double guess = 80, int opencv_frames = 0,
                   const HalvingCamera* camera = nullptr) {
  Renderer renderer = Renderer::make(camera != nullptr ? HalvingCamera::at_twice_the_size(scene) : scene).value();
  std::vector<std::uint8_t> sensor(camera != nullptr ? static_cast<std::size_t>(4 * scene.width() * scene.height()) : 0);
  const auto points = scene.points();
  const dsp::View<double> view = scene.view();
  const dsp::CameraSetup<S> setup{view.cast<S>(), scene.width(), scene.height(), {}};
  dsp::Coefficients<S> start = dsp::Coefficients<S>::Zero(scene.surface.modes.size());
  start[0] = static_cast<S>(guess);
  auto tracker = dsp::SurfaceTracker<S>::make(std::span(&setup, 1), dsp::Pattern::make(points, dsp::FirstSquare::kDark).value(),
                                              scene.surface.cast<S>(), scene.media.cast<S>(), start, {}, {})
                     .value();
  const study::Tank tank{std::span(&view, 1), points, scene.surface, scene.media};
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(scene.width() * scene.height()));
  const GrayView image{pixels.data(), scene.width(), scene.height(), scene.width()};

  struct Surface {
    dsp::Coefficients<double> truth;
    std::vector<int> seen;
  };
  FlumeRun run;
  std::vector<Surface> surfaces;
  std::vector<dsp::Vec2<double>> before;
  OpencvCorners opencv;
  double corner_squares = 0, surface_squares = 0, bound_squares = 0;
  std::vector<double> errors;
  for (int k = 0; k < frames; ++k) {
    const auto frame = static_cast<std::uint64_t>(k);
    if (camera != nullptr) {
      renderer.render(frame, {sensor.data(), 2 * scene.width(), 2 * scene.height(), 2 * scene.width()});
      camera->take(sensor, image, pixels);
    } else {
      renderer.render(frame, {pixels.data(), scene.width(), scene.height(), scene.width()});
    }
    const auto truth = truth_pixels(scene, frame).value();
    if (k < opencv_frames) opencv.add(image, truth);
    for (std::size_t i = 0; i < before.size(); ++i) run.fastest_px = std::max(run.fastest_px, (truth[i] - before[i]).norm());
    before = truth;
    const auto& result = tracker.process(std::span(&image, 1), scene.time_ns(frame));
    ++run.frames;
    if (!result.has_surface() || (result.acquired && k > 0)) ++run.lost;
    if (!result.has_surface()) continue;
    ++run.surfaces;
    Surface surface{scene.coefficients(frame), {}};
    for (const auto& corner : result.observations[0]) {
      const dsp::Vec2<double> e = corner.pixel.template cast<double>() - truth[static_cast<std::size_t>(corner.point)];
      const double square_px = (truth[1] - truth[0]).norm();
      if (e.norm() > square_px / 5) ++run.wrong;
      corner_squares += e.squaredNorm();
      errors.push_back(e.norm());
      surface.seen.push_back(corner.point);
    }
    const double e = study::surface_error(tank, result.estimate.coefficients.template cast<double>(), surface.truth);
    surface_squares += e * e;
    surfaces.push_back(std::move(surface));
  }
  const double corners = static_cast<double>(errors.size());
  run.corner_rms_px = std::sqrt(corner_squares / (2 * corners));
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  run.corner_median_px = *middle / 1.1774;  // of |e| of two normal components
  for (const Surface& surface : surfaces) {
    const auto information = study::information_bound(tank, 0, surface.truth, run.corner_median_px, surface.seen).value();
    const double bound = study::surface_bound(tank, information).value();
    bound_squares += bound * bound;
  }
  run.used_percent = 100.0 * corners / (static_cast<double>(points.size()) * run.surfaces);
  run.surface_rms_mm = std::sqrt(surface_squares / run.surfaces);
  run.bound_rms_mm = std::sqrt(bound_squares / run.surfaces);
  if (opencv_frames > 0) {
    run.opencv_rms_px = opencv.rms();
    run.opencv_window = opencv.best_window();
  }
  return run;
}

}  // namespace srd::accuracy
