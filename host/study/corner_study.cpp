// SPDX-License-Identifier: Apache-2.0
#include "host/study/corner_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "drivers/camera/simulator/renderer.hpp"
#include "dsp/frontend/corner_detector.hpp"
#include "host/study/lower_bound.hpp"

namespace srd::study {

namespace {

constexpr int kWidth = 960, kHeight = 600;  // px
constexpr double kMargin = 24;              // px
constexpr int kMinWindow = 2, kMaxWindow = 16;

// A dry board, turned and in perspective: subpixel phases differ from corner to corner.
Scene board(const CornerConditions& conditions, int variant) {
  Scene scene = default_scene();
  scene.name = "board";
  scene.seed = static_cast<std::uint64_t>(1 + variant);
  scene.calibration.image_width = kWidth;
  scene.calibration.image_height = kHeight;
  scene.calibration.distortion.clear();
  scene.calibration.camera = dsp::CameraModel<double>::make(1900, 1900, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0, {}).value();
  scene.pattern.square_mm = conditions.square_px / 1.9;  // seen from 1 m
  scene.pattern.rows = std::min(14, static_cast<int>(0.8 * kHeight / conditions.square_px) - 1);
  scene.pattern.columns = std::min(24, static_cast<int>(0.8 * kWidth / conditions.square_px) - 1);
  scene.media.water = scene.media.air;
  const dsp::Mode level;
  scene.surface.modes = dsp::ModeList::make({&level, 1}).value();
  scene.motions = {{level, 1, 0, 0, 0}};
  scene.light.dark = 120 - conditions.contrast / 2;
  scene.light.bright = 120 + conditions.contrast / 2;
  scene.blur_px = conditions.blur_px;
  scene.noise = conditions.noise;
  const double x = (scene.pattern.rows - 1) * scene.pattern.square_mm / 2 + 0.3 * variant;
  const double y = (scene.pattern.columns - 1) * scene.pattern.square_mm / 2 - 0.2 * variant;
  scene.pose = look_at({x + 120, y - 60, 990}, {x, y, 0}, 0.031 + 0.07 * variant).value();
  return scene;
}

struct Sums {
  int corners = 0, found = 0;
  double squares = 0, stated = 0;
  std::array<double, kMaxWindow + 1> opencv{};
};

void add_ours(const GrayView& image, const std::vector<dsp::Vec2<double>>& truth, const CornerConditions& conditions,
              dsp::CornerDetector& detector, Sums& sums) {
  dsp::DetectorOptions options;
  // In focus a corner's response is at least 4 contrasts; wide blur takes half of it.
  options.threshold = std::min(options.threshold, static_cast<int>(2 * conditions.contrast));
  const auto found = detector.detect(image, options);
  for (const auto& at : truth)
    for (const dsp::CornerFit& fit : found) {
      const double du = fit.corner.u.to<double>() - at.x(), dv = fit.corner.v.to<double>() - at.y();
      if (std::hypot(du, dv) > 1.5) continue;
      ++sums.found;
      sums.squares += du * du + dv * dv;
      sums.stated += 2 * std::pow(fit.corner.sigma_q12 / 4096.0, 2);
      break;
    }
  sums.corners += static_cast<int>(truth.size());
}

// Started at the pixels nearest to the truth, which no detector does better.
void add_opencv(const GrayView& image, const std::vector<dsp::Vec2<double>>& truth, int most_window, Sums& sums) {
  const cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels),
                       static_cast<std::size_t>(image.stride_bytes));
  for (int window = kMinWindow; window <= most_window; ++window) {
    std::vector<cv::Point2f> corners;
    for (const auto& at : truth)
      corners.emplace_back(static_cast<float>(std::round(at.x())), static_cast<float>(std::round(at.y())));
    cv::cornerSubPix(pixels, corners, {window, window}, {-1, -1}, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-4});
    for (std::size_t i = 0; i < truth.size(); ++i)
      sums.opencv[static_cast<std::size_t>(window)] += std::pow(static_cast<double>(corners[i].x) - truth[i].x(), 2) +
                                                       std::pow(static_cast<double>(corners[i].y) - truth[i].y(), 2);
  }
}

Outcome<CornerRow> measure(const std::string& varied, const CornerConditions& conditions, int boards,
                           dsp::CornerDetector& detector) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(kWidth * kHeight));
  const GrayView image{pixels.data(), kWidth, kHeight, kWidth};
  const int most_window = std::min(kMaxWindow, static_cast<int>(conditions.square_px / 2) - 1);
  Sums sums;
  for (int variant = 0; variant < boards; ++variant) {
    const Scene scene = board(conditions, variant);
    auto renderer = Renderer::make(scene);
    if (!renderer) return renderer.error();
    renderer->render(0, {pixels.data(), kWidth, kHeight, kWidth});
    auto truth = truth_pixels(scene, 0).value();
    // Windows of both must lie inside the image.
    std::erase_if(truth, [](const dsp::Vec2<double>& at) {
      return at.x() < kMargin || at.y() < kMargin || at.x() > kWidth - kMargin || at.y() > kHeight - kMargin;
    });
    add_ours(image, truth, conditions, detector, sums);
    add_opencv(image, truth, most_window, sums);
  }
  CornerRow row{varied, conditions, sums.corners, sums.found};
  row.rms_px = std::sqrt(sums.squares / (2.0 * sums.found));
  row.stated_px = std::sqrt(sums.stated / (2.0 * sums.found));
  row.bound_px = corner_bound(conditions.contrast, conditions.blur_px, conditions.noise, 5);
  const auto first = sums.opencv.begin() + kMinWindow, last = sums.opencv.begin() + most_window + 1;
  const auto best = std::min_element(first, last);
  row.opencv_px = std::sqrt(*best / (2.0 * sums.corners));
  row.opencv_window = static_cast<int>(best - sums.opencv.begin());
  return row;
}

struct Sweep {
  const char* name;
  double CornerConditions::*value;
  std::vector<double> values;
};

const std::vector<Sweep>& sweeps() {
  static const std::vector<Sweep> all{
      {"blur_px", &CornerConditions::blur_px, {0.5, 0.7, 0.9, 1.2, 1.5, 2, 2.5}},
      {"noise", &CornerConditions::noise, {0.5, 1, 2, 3, 4, 6, 8}},
      {"contrast", &CornerConditions::contrast, {30, 60, 100, 150, 200}},
      {"square_px", &CornerConditions::square_px, {12, 15, 18, 22, 28, 38, 50}},
  };
  return all;
}

}  // namespace

double CornerRow::value() const {
  for (const Sweep& sweep : sweeps())
    if (varied == sweep.name) return conditions.*sweep.value;
  return 0;
}

Outcome<std::vector<CornerRow>> study_corners(bool quick, const Progress& progress) {
  dsp::CornerDetector detector(kWidth, kHeight, 4000);
  std::vector<CornerRow> rows;
  int all = 0, done = 0;
  for (const Sweep& sweep : sweeps()) all += static_cast<int>(quick ? 2 : sweep.values.size());
  for (const Sweep& sweep : sweeps()) {
    std::vector<double> values = sweep.values;
    if (quick) values = {values.front(), values.back()};
    for (const double value : values) {
      CornerConditions conditions;
      conditions.*sweep.value = value;
      auto row = measure(sweep.name, conditions, quick ? 1 : 4, detector);
      if (!row) return row.error();
      rows.push_back(std::move(*row));
      if (progress) progress(++done, all);
    }
  }
  return rows;
}

}  // namespace srd::study
