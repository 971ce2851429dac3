// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/image_sketch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace srd {
namespace {

constexpr int kWidth = 320, kHeight = 240;

ImageSketch sketch_of(const std::function<int(int u, int v)>& grey) {
  std::vector<std::uint8_t> pixels;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) pixels.push_back(static_cast<std::uint8_t>(grey(u, v)));
  return ImageSketch({pixels.data(), kWidth, kHeight, kWidth});
}

int board(int u, int v) { return (u / 20 + v / 20) % 2 == 0 ? 40 : 210; }

void expect_words(const ImageSketch& sketch, const char* words) {
  EXPECT_NE(sketch.diagnosis().find(words), std::string::npos) << sketch.diagnosis();
}

TEST(ImageSketch, TellsWhyAnImageShowsNoPattern) {
  expect_words(sketch_of([](int, int) { return 0; }), "nearly black");
  expect_words(sketch_of([](int u, int v) { return board(u, v) >> 4; }), "10 or 12 bits at the lower end of 16");
  expect_words(sketch_of([](int u, int v) { return board(u, v) / 7; }), "too dark");
  expect_words(sketch_of([](int u, int v) { return board(u, v) == 210 ? 255 : 90; }), "50 % of it is saturated");
  expect_words(sketch_of([](int, int) { return 120; }), "little contrast");
  expect_words(sketch_of([](int u, int) { return 128 + static_cast<int>(std::lround(90 * std::sin(u / 12.0))); }), "blurred");
  expect_words(sketch_of(board), "looks sound (grey levels 40 to 210)");
  EXPECT_EQ(ImageSketch().diagnosis(), "");
}

// Red, green; green, blue of a scene with a colour cast.
TEST(ImageSketch, KnowsAMosaicFromNoise) {
  expect_words(sketch_of([](int u, int v) {
                 const int gain = u % 2 == 0 && v % 2 == 0 ? 55 : u % 2 == 1 && v % 2 == 1 ? 40 : 100;
                 return board(u, v) * gain / 100;
               }),
               "mosaic of a colour sensor");
  std::mt19937 random(1);
  expect_words(sketch_of([&](int u, int v) { return board(u, v) - 30 + static_cast<int>(random() % 60); }), "looks sound");
}

// An edge of blur s rises by erf(2 / (s sqrt 2)) of its height within the 4 px round it.
TEST(ImageSketch, SteepestPartOfAnEdgeIsThatOfItsBlur) {
  for (const double s : {1.0, 2.0, 4.0, 6.0}) {
    const ImageSketch edges = sketch_of([&](int u, int) {
      const double at = u % 160 < 80 ? u % 80 - 40 : 40 - u % 80;
      return static_cast<int>(std::lround(128 + 100 * std::erf(at / (s * std::sqrt(2.0)))));
    });
    EXPECT_NEAR(edges.steepest(), std::erf(2 / (s * std::sqrt(2.0))), 0.02) << s;
    EXPECT_EQ(edges.fault(), s > 4.4 ? ImageFault::kBlurred : ImageFault::kNone) << s;
  }
}

// A dark room with a board in one corner: its edges are judged, not how much of the image they fill.
TEST(ImageSketch, ABoardInASmallPartOfTheImageIsJudgedByItsOwnEdges) {
  for (const double s : {1.0, 8.0}) {
    const ImageSketch small = sketch_of([&](int u, int v) {
      const auto edge = [&](int at) { return std::erf((u - at) / (s * std::sqrt(2.0))); };
      return v < 70 ? 40 + static_cast<int>(std::lround(90 * (edge(30) - edge(70)))) : 40;
    });
    EXPECT_NEAR(small.steepest(), std::erf(2 / (s * std::sqrt(2.0))), 0.03) << s;
    EXPECT_EQ(small.fault(), s > 4.4 ? ImageFault::kBlurred : ImageFault::kNone) << s;
  }
}

TEST(ImageSketch, LevelsAndDifferencesAreThoseOfTheImage) {
  const ImageSketch ramp = sketch_of([](int u, int) { return u % 256; });
  EXPECT_EQ(ramp.level(1000), 255);
  EXPECT_LE(ramp.level(10), 2);
  const ImageSketch stripes = sketch_of([](int u, int) { return u % 2 == 0 ? 10 : 110; });
  EXPECT_EQ(stripes.neighbours(), 100);
  EXPECT_EQ(stripes.second_neighbours(), 0);
}

}  // namespace
}  // namespace srd
