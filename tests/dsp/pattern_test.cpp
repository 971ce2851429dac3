// SPDX-License-Identifier: Apache-2.0
#include "dsp/pipeline/pattern.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace srd::dsp {
namespace {

std::vector<Vec3<double>> grid(int rows, int columns, double square, double x0 = 0, double y0 = 0) {
  std::vector<Vec3<double>> points;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) points.emplace_back(x0 + r * square, y0 + c * square, 0);
  return points;
}

TEST(Pattern, KnowsItsGridWhateverTheOrder) {
  auto points = grid(4, 7, 20, 10, -40);
  std::reverse(points.begin(), points.end());
  points.erase(points.begin() + 5);
  const auto pattern = Pattern::make(points, FirstSquare::kDark);
  ASSERT_TRUE(pattern.ok());
  EXPECT_EQ(pattern->rows(), 4);
  EXPECT_EQ(pattern->columns(), 7);
  EXPECT_DOUBLE_EQ(pattern->square(), 20);
  EXPECT_DOUBLE_EQ(pattern->centre().x(), 40);
  EXPECT_DOUBLE_EQ(pattern->centre().y(), 20);
  for (int i = 0; i < pattern->size(); ++i) EXPECT_EQ(pattern->at(pattern->row(i), pattern->column(i)), i);
  EXPECT_EQ(pattern->at(-1, 0), -1);
  EXPECT_EQ(pattern->at(0, 7), -1);
}

TEST(Pattern, NeighboursDifferInParityAndTheOriginIsEven) {
  const auto pattern = Pattern::make(grid(3, 5, 10, -10, -20), FirstSquare::kDark);
  ASSERT_TRUE(pattern.ok());
  EXPECT_FALSE(pattern->odd(pattern->at(1, 2)));  // (0, 0) mm
  for (int r = 0; r + 1 < 3; ++r)
    for (int c = 0; c + 1 < 5; ++c) {
      EXPECT_NE(pattern->odd(pattern->at(r, c)), pattern->odd(pattern->at(r + 1, c)));
      EXPECT_NE(pattern->odd(pattern->at(r, c)), pattern->odd(pattern->at(r, c + 1)));
    }
}

TEST(Pattern, APrintThatWasMeasuredKeepsItsGrid) {
  // Off by 0.15 mm each way: the least distance is 9.7, and over 38 squares of that a square would be lost.
  auto points = grid(39, 10, 10);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] += 0.15 * Vec3<double>(std::sin(2.3 * static_cast<double>(i * i)), std::cos(1.7 * static_cast<double>(i * i)), 0);
  const auto pattern = Pattern::make(points, FirstSquare::kDark);
  ASSERT_TRUE(pattern.ok());
  EXPECT_EQ(pattern->rows(), 39);
  EXPECT_EQ(pattern->columns(), 10);
  EXPECT_NEAR(pattern->square(), 10, 0.05);
  for (int i = 0; i < pattern->size(); ++i) EXPECT_EQ(10 * pattern->row(i) + pattern->column(i), i);
}

TEST(Pattern, RefusesPointsThatAreNoBoard) {
  auto off = grid(3, 3, 10);
  off[4].x() += 0.8;
  EXPECT_FALSE(Pattern::make(off, FirstSquare::kDark).ok());
  auto twice = grid(3, 3, 10);
  twice.push_back(twice.front());
  EXPECT_FALSE(Pattern::make(twice, FirstSquare::kDark).ok());
  auto nan = grid(3, 3, 10);
  nan[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Pattern::make(nan, FirstSquare::kDark).ok());
  EXPECT_FALSE(Pattern::make(grid(1, 1, 10), FirstSquare::kDark).ok());
}

}  // namespace
}  // namespace srd::dsp
