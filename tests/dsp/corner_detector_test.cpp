// SPDX-License-Identifier: Apache-2.0
// All corners of a rendered board, whatever else is in the image.
#include "dsp/frontend/corner_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "drivers/camera/simulator/renderer.hpp"
#include "dsp/frontend/noise_threshold.hpp"

namespace srd::dsp {
namespace {

class BoardImage {
 public:
  explicit BoardImage(double blur_px) : scene_(default_scene()) {
    scene_.blur_px = blur_px;
    pixels_.resize(static_cast<std::size_t>(scene_.width() * scene_.height()));
    Renderer::make(scene_).value().render(0, {pixels_.data(), scene_.width(), scene_.height(), scene_.width()});
  }
  GrayView view() const { return {pixels_.data(), scene_.width(), scene_.height(), scene_.width()}; }
  // Cells of black and white at random along the upper edge: lettering, as cameras write into images, gravel, leaves.
  void scatter(int cell_width, int cell_height, int rows) {
    std::mt19937 random(1);
    for (int v = 0; v < rows; v += cell_height)
      for (int u = 0; u < scene_.width(); u += cell_width) {
        const std::uint8_t level = random() % 2 == 0 ? 0 : 255;
        for (int y = v; y < std::min(v + cell_height, rows); ++y)
          for (int x = u; x < std::min(u + cell_width, scene_.width()); ++x)
            pixels_[static_cast<std::size_t>(y * scene_.width() + x)] = level;
      }
  }
  // Grey levels about the middle times contrast, and noise of this standard deviation.
  void fade(double contrast, double noise) {
    std::mt19937 random(2);
    std::normal_distribution<double> normal(0, noise);
    for (std::uint8_t& pixel : pixels_)
      pixel = static_cast<std::uint8_t>(std::clamp(std::lround(128 + contrast * (pixel - 128) + normal(random)), 0L, 255L));
  }
  // Of the pattern's corners, how many have a detected one within half a pixel.
  int found(std::span<const CornerFit> corners) const {
    const auto truth = truth_pixels(scene_, 0).value();
    return static_cast<int>(std::count_if(truth.begin(), truth.end(), [&](const Vec2<double>& q) {
      return std::any_of(corners.begin(), corners.end(), [&](const CornerFit& fit) {
        return std::hypot(fit.corner.u.to<double>() - q.x(), fit.corner.v.to<double>() - q.y()) < 0.5;
      });
    }));
  }

 private:
  Scene scene_;
  std::vector<std::uint8_t> pixels_;
};

// The threshold of the image's own noise finds what the fixed one loses, and keeps noise out.
TEST(CornerDetectorNoiseThreshold, FollowsNoiseDownToFaintBoards) {
  CornerDetector detector(1280, 640, 4000);
  for (const auto& [contrast, noise] : {std::pair(0.15, 0.3), std::pair(0.3, 2.0), std::pair(1.0, 4.0), std::pair(1.0, 8.0)}) {
    BoardImage image(1);
    image.fade(contrast, noise);
    DetectorOptions options;
    options.threshold = noise_threshold(image.view());
    EXPECT_NEAR(options.threshold, std::max(16 * std::hypot(noise, contrast * 1.5), 32.0), 0.15 * 16 * noise + 3) << noise;
    const auto corners = detector.detect(image.view(), options);
    EXPECT_EQ(image.found(corners), 231) << contrast;
    EXPECT_LE(corners.size(), 235u) << noise;
    options.threshold = 200;
    if (contrast < 0.2) {
      EXPECT_LT(image.found(detector.detect(image.view(), options)), 231);
    }
  }
}

TEST(CornerDetectorNoiseThreshold, IsThatOfWhiteNoise) {
  for (const double noise : {2.0, 5.0, 12.0}) {
    BoardImage image(1);
    image.fade(0, noise);
    EXPECT_NEAR(noise_threshold(image.view()), 16 * noise, 0.05 * 16 * noise);
  }
}

class CornerDetectorBeside : public testing::TestWithParam<std::pair<int, int>> {};

// Some of it passes for a corner of a blur that no corner of the board has.
TEST_P(CornerDetectorBeside, ClutterHidesNoCorner) {
  BoardImage image(1);
  CornerDetector detector(1280, 640, 4000);
  const DetectorOptions options;
  ASSERT_EQ(image.found(detector.detect(image.view(), options)), 231);
  image.scatter(GetParam().first, GetParam().second, 64);
  EXPECT_EQ(image.found(detector.detect(image.view(), options)), 231);
}

INSTANTIATE_TEST_SUITE_P(Cells, CornerDetectorBeside,
                         testing::Values(std::pair(1, 1), std::pair(2, 2), std::pair(2, 4), std::pair(3, 3), std::pair(4, 4),
                                         std::pair(5, 5), std::pair(6, 6), std::pair(8, 8)));

}  // namespace
}  // namespace srd::dsp
