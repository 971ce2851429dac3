// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/board_finder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

namespace srd::dsp {
namespace {

// A print of rows x columns inner corners on a white sheet, seen in perspective; every pixel the mean of 5 x 5 points.
struct Print {
  int rows = 7, columns = 11;
  double square = 40;  // px
  double ink = 0;      // what a dark square is larger on each side, squares
  double wave = 0;     // px
  double squeeze = 0;  // of a square: squares are 1/(1 + squeeze) to 1/(1 - squeeze) as wide, to and fro within 12 of them
  int gain = 1;        // levels times this, clipped at white

  Eigen::Vector2d board_of(double u, double v) const {
    const double around = 12 * square / 6.283185307;
    u += squeeze * around * std::sin((u + 0.5 * v) / around) + wave * std::sin(v / (4 * square));
    v += wave * std::cos(u / (5 * square));
    const double x = (u - 2.2 * square) / square, y = (v - 2.1 * square) / square;
    const double w = 1 - 0.066 * x / columns - 0.028 * y / rows;
    return {(x + 0.06 * y) / w, (y - 0.04 * x) / w};
  }
  // Dark squares (even sum) grown by the ink; corner (r, c) lies at (c, r).
  double level(double u, double v) const {
    const Eigen::Vector2d at = board_of(u, v);
    const double dark = 15, white = 200;
    if (at.x() < -1 - ink || at.y() < -1 - ink || at.x() > columns + ink || at.y() > rows + ink) return white;
    for (const double dx : {-ink, ink})
      for (const double dy : {-ink, ink}) {
        const double x = std::floor(at.x() + dx), y = std::floor(at.y() + dy);
        if (x < -1 || y < -1 || x >= columns || y >= rows) continue;
        if (static_cast<int>(std::abs(x + y)) % 2 == 0) return dark;
      }
    return white;
  }
  int width() const { return static_cast<int>((columns + 5) * square); }
  int height() const { return static_cast<int>((rows + 5) * square); }
  std::vector<std::uint8_t> render() const {
    std::vector<std::uint8_t> pixels;
    for (int v = 0; v < height(); ++v)
      for (int u = 0; u < width(); ++u) {
        double sum = 0;
        for (int i = -2; i <= 2; ++i)
          for (int k = -2; k <= 2; ++k) sum += level(u + 0.45 * i, v + 0.45 * k);
        pixels.push_back(static_cast<std::uint8_t>(std::min(255.0, gain * (sum / 25 + 0.5))));
      }
    return pixels;
  }
  // How many cells of the grid are the corner that they say; a wrong one is -1 at once.
  int right(const CornerGrid& grid, std::span<const CornerFit> corners, double within) const {
    int count = 0;
    for (int r = 0; r < grid.rows; ++r)
      for (int c = 0; c < grid.columns; ++c) {
        if (grid.at(r, c) < 0) continue;
        const Corner& corner = corners[static_cast<std::size_t>(grid.at(r, c))].corner;
        const Eigen::Vector2d at = board_of(corner.u.to<double>(), corner.v.to<double>());
        if (std::hypot(at.x() - c, at.y() - r) > within) return -1;
        ++count;
      }
    return count;
  }
};

void expect_whole(const Print& print, int least, double within) {
  const std::vector<std::uint8_t> pixels = print.render();
  BoardFinder finder(print.width(), print.height(), 8000);
  const auto grid = finder.find({pixels.data(), print.width(), print.height(), print.width()}, {});
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->rows, print.rows);
  EXPECT_EQ(grid->columns, print.columns);
  EXPECT_GE(print.right(*grid, finder.corners(), within), least);
}

TEST(BoardFinder, JoinsCornersOfSpreadInk) {
  for (const double ink : {0.0, 0.01, 0.02, 0.03}) {
    SCOPED_TRACE(ink);
    expect_whole({.ink = ink}, 77, 0.06);
  }
}

TEST(BoardFinder, JoinsCornersOfSpreadInkWithClippedWhites) {
  for (const double ink : {0.0, 0.02}) {
    SCOPED_TRACE(ink);
    expect_whole({.ink = ink, .gain = 2}, 72, 0.08);
  }
}

TEST(BoardFinder, FollowsSquaresSmallerThanTheLeastDistance) {
  for (const double square : {6.9, 7.7}) {
    SCOPED_TRACE(square);
    // A pixel or so of error is a fifth of a square here; a wrong cell is a whole one.
    expect_whole({.rows = 30, .columns = 40, .square = square, .wave = 2}, 1140, 0.25);
  }
}

// Crests across the board squeeze its squares until no corner is detected there: the grid goes on over what is sighted, and
// never out of step.
TEST(BoardFinder, GoesOnAcrossSqueezedSquares) {
  for (const double squeeze : {0.3, 0.45, 0.6}) {
    SCOPED_TRACE(squeeze);
    const Print print{.rows = 30, .columns = 48, .square = 7.5, .squeeze = squeeze};
    // What is squeezed most is sighted, not measured. A pixel is a fifth of the narrowest square.
    expect_whole(print, 35 * print.rows * print.columns / 100, 0.35);
  }
}

// A few corners above a high threshold in a large faint board: many more are sighted than were detected.
TEST(BoardFinder, FewDetectedCornersLeadToManySightedOnes) {
  const Print print{.rows = 25, .columns = 30, .square = 20};
  std::vector<std::uint8_t> pixels = print.render();
  for (int v = 0; v < print.height(); ++v)
    for (int u = 0; u < print.width(); ++u) {
      const bool lit = std::abs(u - print.width() / 2) < 50 && std::abs(v - print.height() / 2) < 50;
      std::uint8_t& pixel = pixels[static_cast<std::size_t>(v * print.width() + u)];
      if (!lit) pixel = static_cast<std::uint8_t>(100 + pixel / 5);
    }
  BoardFinder finder(print.width(), print.height(), 4000);
  DetectorOptions options;
  options.threshold = 300;
  const auto grid = finder.find({pixels.data(), print.width(), print.height(), print.width()}, options);
  ASSERT_TRUE(grid.ok());
  EXPECT_GE(grid->found, 16);
  // Counted from the grid's own first corner.
  std::vector<Eigen::Vector2d> shifts;
  for (int r = 0; r < grid->rows; ++r)
    for (int c = 0; c < grid->columns; ++c)
      if (grid->at(r, c) >= 0) {
        const Corner& corner = finder.corners()[static_cast<std::size_t>(grid->at(r, c))].corner;
        shifts.push_back(print.board_of(corner.u.to<double>(), corner.v.to<double>()) - Eigen::Vector2d(c, r));
      }
  for (const Eigen::Vector2d& shift : shifts) EXPECT_LT((shift - shifts.front()).norm(), 0.2);
}

TEST(BoardFinder, SquaresOfTheAnnouncedSizeAreSearchedOnce) {
  const Print print{.rows = 9, .columns = 12, .square = 14};
  expect_whole(print, 108, 0.05);
}

// A dark thing outside meets the sheet where a square's edge would go on: one corner too many.
TEST(BoardFinder, ABoardOfKnownSizeLeavesOutACornerOfItsSurroundings) {
  const Print print{.rows = 6, .columns = 8};
  std::vector<std::uint8_t> pixels = print.render();
  const GrayView image{pixels.data(), print.width(), print.height(), print.width()};
  // Dark beyond the first row of squares but for a white block: with the dark square below it crosses a square up.
  for (int v = 0; v < print.height(); ++v)
    for (int u = 0; u < print.width(); ++u) {
      const Eigen::Vector2d at = print.board_of(u, v);
      if (at.y() < -1 && at.x() > 2 && at.x() < 3) pixels[static_cast<std::size_t>(v * print.width() + u)] = 30;
    }
  BoardFinder finder(print.width(), print.height(), 1000);
  const auto any = finder.find(image, {});
  ASSERT_TRUE(any.ok());
  EXPECT_GT(any->found, 48) << "the scene has no false corner that joins: it tests nothing";
  const auto grid = finder.find(image, {}, {6, 8});
  ASSERT_TRUE(grid.ok());
  EXPECT_TRUE(grid->complete());
  EXPECT_EQ(print.right(*grid, finder.corners(), 0.05), 48);
  EXPECT_GT(grid->lead, 4);
}

}  // namespace
}  // namespace srd::dsp
