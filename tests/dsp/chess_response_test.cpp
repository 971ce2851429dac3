// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/chess_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace srd::dsp {
namespace {

// Optics (22) word by word, with the offsets as the page lists them.
int by_definition(const GrayView& image, int u, int v, int radius, bool mean_term) {
  static const int x5[] = {0, 2, 4, 5, 5, 5, 4, 2, 0, -2, -4, -5, -5, -5, -4, -2};
  static const int y5[] = {-5, -5, -4, -2, 0, 2, 4, 5, 5, 5, 4, 2, 0, -2, -4, -5};
  static const int x10[] = {0, 4, 7, 10, 10, 10, 7, 4, 0, -4, -7, -10, -10, -10, -7, -4};
  static const int y10[] = {-10, -10, -7, -4, 0, 4, 7, 10, 10, 10, 7, 4, 0, -4, -7, -10};
  int sample[16], circle = 0;
  for (int n = 0; n < 16; ++n) {
    sample[n] = radius == 5 ? image.row(v + y5[n])[u + x5[n]] : image.row(v + y10[n])[u + x10[n]];
    circle += sample[n];
  }
  int sum = 0, difference = 0;
  for (int n = 0; n < 4; ++n) sum += std::abs(sample[n] + sample[n + 8] - sample[n + 4] - sample[n + 12]);
  for (int n = 0; n < 8; ++n) difference += std::abs(sample[n] - sample[n + 8]);
  if (!mean_term) return sum - difference;
  const int cross = image.row(v)[u] + image.row(v)[u - 1] + image.row(v)[u + 1] + image.row(v - 1)[u] + image.row(v + 1)[u];
  return sum - difference - static_cast<int>(std::floor(16 * std::abs(circle / 16.0 - cross / 5.0) + 1e-9));
}

TEST(ChessResponse, FollowsItsDefinition) {
  std::mt19937 random(1);
  for (const int radius : {5, 10})
    for (const bool mean_term : {false, true}) {
      std::vector<std::uint8_t> pixels(61 * 47);
      for (auto& p : pixels) p = static_cast<std::uint8_t>(random());
      const GrayView image{pixels.data(), 53, 47, 61};
      for (int v = radius; v < image.height - radius; ++v) {
        std::vector<std::int16_t> row(static_cast<std::size_t>(image.width - 2 * radius));
        response_row(image, v, radius, image.width - radius, {radius, mean_term}, row.data());
        for (int u = radius; u < image.width - radius; ++u) {
          ASSERT_EQ(row[static_cast<std::size_t>(u - radius)], by_definition(image, u, v, radius, mean_term));
          ASSERT_EQ(response_at(image, u, v, {radius, mean_term}), row[static_cast<std::size_t>(u - radius)]);
        }
      }
    }
}

TEST(ChessResponse, StaysWithinItsStatedRange) {
  std::mt19937 random(2);
  for (int k = 0; k < 5000; ++k) {
    std::vector<std::uint8_t> pixels(21 * 21);
    for (auto& p : pixels) p = (random() & 1) != 0 ? 255 : 0;
    const int r = response_at({pixels.data(), 21, 21, 21}, 10, 10, {5, true});
    ASSERT_GE(r, -6120);
    ASSERT_LE(r, 2040);
  }
}

TEST(ChessResponse, IsStrongAtCornersAndNotAtEdgesOrFlats) {
  std::vector<std::uint8_t> pixels(60 * 60);
  for (int i = 0; i < 60 * 60; ++i) pixels[static_cast<std::size_t>(i)] = (i % 60 / 20 + i / 60 / 20) % 2 == 0 ? 20 : 220;
  const GrayView image{pixels.data(), 60, 60, 60};
  EXPECT_GE(response_at(image, 20, 20, {5, false}), 4 * 200);
  EXPECT_LE(response_at(image, 20, 30, {5, false}), 0);  // on an edge
  EXPECT_EQ(response_at(image, 30, 30, {5, false}), 0);  // inside a square
}

TEST(ChessResponse, MeanTermRejectsStripes) {
  std::vector<std::uint8_t> pixels(41 * 41);
  for (int i = 0; i < 41 * 41; ++i) pixels[static_cast<std::size_t>(i)] = std::abs(i % 41 - 20) <= 3 ? 220 : 20;
  const GrayView image{pixels.data(), 41, 41, 41};
  EXPECT_GT(response_at(image, 20, 20, {5, false}), 200);
  EXPECT_LT(response_at(image, 20, 20, {5, true}), 0);
}

}  // namespace
}  // namespace srd::dsp
