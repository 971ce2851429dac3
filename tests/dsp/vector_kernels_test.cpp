// SPDX-License-Identifier: Apache-2.0
// Every vector unit that this machine has gives what the scalar definition gives, bit for bit.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "dsp/frontend/chess_response.hpp"
#include "dsp/frontend/corner_sums.hpp"
#include "dsp/frontend/edge_profile.hpp"

namespace srd::dsp {
namespace {

// Runs the test for one unit; the best one is chosen again afterwards.
class VectorKernels : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { choose(GetParam()); }
  void TearDown() override { choose(0); }
  static void choose(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

std::vector<std::int64_t> units() {
  std::vector<std::int64_t> out;
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) out.push_back(rest & -rest);
  return out;
}

std::vector<std::uint8_t> random_pixels(std::mt19937& random, std::size_t n) {
  std::vector<std::uint8_t> pixels(n);
  // Also extremes, where saturation would show.
  const bool extreme = random() % 3 == 0;
  for (auto& p : pixels) p = static_cast<std::uint8_t>(extreme ? (random() & 1) * 255 : random());
  return pixels;
}

TEST_P(VectorKernels, ResponseEqualsTheDefinition) {
  std::mt19937 random(1);
  for (int k = 0; k < 600; ++k) {
    const int radius = random() % 2 == 0 ? 5 : 10;
    const ResponseOptions options{radius, random() % 2 == 0};
    const int width = 2 * radius + 1 + static_cast<int>(random() % 150), height = 2 * radius + 1;
    const int stride = width + static_cast<int>(random() % 9);
    const auto pixels = random_pixels(random, static_cast<std::size_t>(stride * height + 7));
    const GrayView image{pixels.data() + random() % 7, width, height, stride};
    const int u0 = radius + static_cast<int>(random() % static_cast<unsigned>(width - 2 * radius)), u1 = width - radius;
    const auto n = static_cast<std::size_t>(u1 - u0);
    std::vector<std::int16_t> expected(n), got(n + 1, 12345);
    scalar::response_row(image, radius, u0, u1, options, expected.data());
    response_row(image, radius, u0, u1, options, got.data());
    ASSERT_EQ(got.back(), 12345);
    got.pop_back();
    ASSERT_EQ(got, expected) << "width " << width << " from " << u0;
  }
}

TEST_P(VectorKernels, ResponsesAboveAThresholdEqualTheDefinition) {
  std::mt19937 random(5);
  int above = 0, below = 0;
  for (int k = 0; k < 400; ++k) {
    const ResponseOptions options{random() % 2 == 0 ? 5 : 10, random() % 2 == 0};
    const int height = 2 * options.radius + 1, width = height + static_cast<int>(random() % 200);
    const auto pixels = random_pixels(random, static_cast<std::size_t>(width * height));
    const GrayView image{pixels.data(), width, height, width};
    const auto threshold = static_cast<std::int16_t>(random() % (k % 2 == 0 ? 100 : 900));
    const auto n = static_cast<std::size_t>(width - 2 * options.radius);
    std::vector<std::int16_t> expected(n), got(n + 1, 12345);
    scalar::response_row(image, options.radius, options.radius, width - options.radius, options, expected.data());
    response_row_above(image, options.radius, options.radius, width - options.radius, options, threshold, got.data());
    ASSERT_EQ(got[n], 12345);
    for (std::size_t i = 0; i < n; ++i) {
      if (expected[i] > threshold)
        ASSERT_EQ(got[i], expected[i]);
      else
        ASSERT_LE(got[i], threshold);
      ++(expected[i] > threshold ? above : below);
    }
  }
  EXPECT_GT(above, 1000);
  EXPECT_GT(below, 1000);
}

TEST_P(VectorKernels, RowMaximaEqualTheDefinition) {
  std::mt19937 random(2);
  for (int k = 0; k < 2000; ++k) {
    const int n = 1 + static_cast<int>(random() % 120);
    const int levels = 2 + static_cast<int>(random() % 40);  // few: many equal neighbours
    std::vector<std::int16_t> rows[3];
    for (auto& row : rows)
      for (int i = 0; i < n; ++i)
        row.push_back(static_cast<std::int16_t>(static_cast<int>(random() % 4000) / levels * levels - 2000));
    const auto threshold = static_cast<std::int16_t>(static_cast<int>(random() % 3000) - 1500);
    std::vector<std::int32_t> expected(static_cast<std::size_t>(n / 2 + 2), -1), got = expected;
    const int count = scalar::row_maxima(rows[0].data(), rows[1].data(), rows[2].data(), n, threshold, expected.data());
    ASSERT_EQ(row_maxima(rows[0].data(), rows[1].data(), rows[2].data(), n, threshold, got.data()), count);
    expected.resize(static_cast<std::size_t>(count));
    got.resize(static_cast<std::size_t>(count));
    ASSERT_EQ(got, expected);
  }
}

TEST_P(VectorKernels, ResponseWindowAndItsPeakEqualTheDefinition) {
  std::mt19937 random(4);
  int others = 0;
  for (int k = 0; k < 600; ++k) {
    const ResponseOptions options{random() % 2 == 0 ? 5 : 10, random() % 4 == 0};
    const int side = 3 + static_cast<int>(random() % (ResponseWindow::kMaxSide - 2));
    const int least = side + 2 * options.radius;
    const int width = least + static_cast<int>(random() % 20), height = least + static_cast<int>(random() % 3);
    auto pixels = random_pixels(random, static_cast<std::size_t>(width * height));
    if (k % 2 == 0)  // squares, so that there are real corners
      for (int i = 0; i < width * height; ++i)
        pixels[static_cast<std::size_t>(i)] =
            static_cast<std::uint8_t>(((i % width / 13 + i / width / 13) % 2) * 200 + random() % 8);
    const GrayView image{pixels.data(), width, height, width};
    const int u0 = options.radius + static_cast<int>(random() % static_cast<unsigned>(width - least + 1));
    const int v0 = options.radius + static_cast<int>(random() % static_cast<unsigned>(height - least + 1));
    ResponseWindow expected, got;
    scalar::response_window(image, u0, v0, side, options, expected);
    response_window(image, u0, v0, side, options, got);
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < (side + 7) / 8 * 8; ++j) ASSERT_EQ(got.row(i)[j], expected.row(i)[j]) << i << ' ' << j;
    const auto threshold = static_cast<std::int16_t>(random() % 600);
    const WindowPeak a = scalar::window_peak(expected, threshold), b = window_peak(got, threshold);
    ASSERT_EQ(a.row, b.row);
    ASSERT_EQ(a.column, b.column);
    ASSERT_EQ(a.response, b.response);
    ASSERT_EQ(a.another, b.another);
    others += a.another ? 1 : 0;
  }
  EXPECT_GT(others, 50);
}

TEST_P(VectorKernels, CornerSumsEqualTheDefinition) {
  std::mt19937 random(3);
  const auto number = [&](int limit) {
    return static_cast<std::int16_t>(static_cast<int>(random() % (2u * static_cast<unsigned>(limit) + 1)) - limit);
  };
  for (int k = 0; k < 800; ++k) {
    const CornerWindow& window = corner_window(kMinHalfWindow + k % (kMaxHalfWindow - kMinHalfWindow + 1));
    auto pixels = random_pixels(random, CornerWindow::kRoom);
    for (std::uint8_t& pixel : pixels)  // many cut off at black and white
      if (pixel < 40 || pixel > 215) pixel = pixel < 40 ? 0 : 255;
    CornerModel model;
    // Blur down to the pixel's own, the corner up to 7 px off the window's centre.
    const auto across = [&](CornerModel::Line& line) {
      const double angle = static_cast<double>(random() % 6283) / 1000, size = static_cast<double>(random() % 3548);
      line = {static_cast<std::int16_t>(size * std::cos(angle)), static_cast<std::int16_t>(size * std::sin(angle)),
              number(20000)};
    };
    const auto shape = [&] { return static_cast<std::uint8_t>(random() % EdgeProfile::kShapes); };
    for (std::size_t edge = 0; edge < 2; ++edge) {
      across(model.across[edge]);
      across(model.mask.across[edge]);
      model.shape[edge] = shape();
      model.mask.shape[edge] = shape();
    }
    if (k % 2 == 1) {
      model.mask.amount_q13 = static_cast<std::int16_t>(random() % (CornerModel::kMostAmountQ13 + 1));
      model.mask.narrower_q15 = static_cast<std::int16_t>(random() % 32768);
    }
    for (auto& line : model.along) line = {number(1024), number(1024), number(7168)};
    model.rho_q15 = number(31785);
    model.mean_q6 = static_cast<std::int16_t>(random() % 16321);
    model.contrast_q8 = number(32767);
    CornerSums expected, got;
    scalar::corner_sums(window, pixels.data(), model, expected);
    corner_sums(window, pixels.data(), model, got);
    ASSERT_EQ(got.product, expected.product) << "window " << window.size;
  }
}

INSTANTIATE_TEST_SUITE_P(OfThisMachine, VectorKernels, testing::ValuesIn(units()),
                         [](const auto& unit) { return std::string(hwy::TargetName(unit.param)); });

}  // namespace
}  // namespace srd::dsp
