// SPDX-License-Identifier: Apache-2.0
// Full detection of the scene "board", and what other detectors take for it.
#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "drivers/camera/simulator/renderer.hpp"
#include "dsp/frontend/corner_detector.hpp"
#include "tests/bench/measures.hpp"
#include "tests/bench/scenes.hpp"

namespace srd::bench {

namespace {

struct Board {
  GrayImage image;
  std::vector<dsp::Vec2<double>> truth;
  dsp::CornerDetector detector;
  std::vector<std::int16_t> responses;
  cv::Mat harris;
  std::vector<cv::Point2f> corners;
  [[nodiscard]] cv::Mat mat() { return {image.height, image.width, CV_8U, image.pixels.data()}; }

  explicit Board(const Scene& scene)
      : image{std::vector<std::uint8_t>(static_cast<std::size_t>(scene.width() * scene.height())), scene.width(),
              scene.height()},
        truth(truth_pixels(scene, 0).value()),
        detector(scene.width(), scene.height(), 4000),
        responses(static_cast<std::size_t>(scene.width())) {
    Renderer::make(scene).value().render(0, {image.pixels.data(), image.width, image.height, image.width});
  }
};

}  // namespace

void add_board_measures(std::vector<Measure>& measures) {
  const auto board = std::make_shared<Board>(board_scene());
  const dsp::DetectorOptions options;
  const auto found = board->detector.detect(board->image.view(), options);
  std::size_t right = 0;
  for (const auto& at : board->truth)
    for (const dsp::CornerFit& fit : found)
      if (std::hypot(fit.corner.u.to<double>() - at.x(), fit.corner.v.to<double>() - at.y()) < 0.5) {
        ++right;
        break;
      }
  if (right != board->truth.size())
    refuse("the detector finds " + std::to_string(right) + " of " + std::to_string(board->truth.size()) + " corners");

  measures.push_back({"board/detect", [=] { (void)board->detector.detect(board->image.view(), options); }});
  measures.push_back({"board/response", [=] {
                        const GrayView image = board->image.view();
                        for (int v = 5; v < image.height - 5; ++v)
                          dsp::response_row(image, v, 5, image.width - 5, {}, board->responses.data());
                      }});
  measures.push_back({"board/cornerHarris", [=] { cv::cornerHarris(board->mat(), board->harris, 5, 3, 0.04); }});
  measures.push_back({"board/cornerSubPix", [=] {
                        board->corners.clear();
                        for (const auto& at : board->truth)
                          board->corners.emplace_back(static_cast<float>(std::round(at.x())),
                                                      static_cast<float>(std::round(at.y())));
                        cv::cornerSubPix(board->mat(), board->corners, {5, 5}, {-1, -1},
                                         {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-4});
                      }});
  measures.push_back({"board/findChessboardCornersSB",
                      [=] {
                        (void)cv::findChessboardCornersSB(board->mat(), {40, 22}, board->corners);
                      },
                      true});
}

}  // namespace srd::bench
