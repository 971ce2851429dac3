// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/grid_labelling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Dense>

namespace srd::dsp {
namespace {

// A board of rows x columns corners seen in perspective and through a gentle wave, in random order.
struct SyntheticBoard {
  int rows, columns;
  double turn = 0.1, tilt = 2e-4, wave = 3;
  std::vector<CornerFit> corners;
  std::vector<std::pair<int, int>> cells;  // of each corner

  Eigen::Vector2d project(double row, double column) const {
    const double x = 40 * (column - columns / 2.0), y = 36 * (row - rows / 2.0);
    const double u = std::cos(turn) * x - std::sin(turn) * y, v = std::sin(turn) * x + std::cos(turn) * y;
    const double w = 1 + tilt * (u + 2 * v);
    return {640 + u / w + wave * std::sin(v / 60), 320 + v / w + wave * std::cos(u / 80)};
  }
  void make(unsigned seed) {
    std::mt19937 random(seed);
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c) cells.emplace_back(r, c);
    std::shuffle(cells.begin(), cells.end(), random);
    for (const auto& [r, c] : cells)
      corners.push_back(corner(project(r, c), project(r, c + 0.1) - project(r, c - 0.1),
                               project(r + 0.1, c) - project(r - 0.1, c), (r + c) % 2 != 0));
  }
  // bright: below and right of the corner.
  static CornerFit corner(const Eigen::Vector2d& at, const Eigen::Vector2d& right, const Eigen::Vector2d& down, bool bright) {
    const auto normal = [](Eigen::Vector2d edge, int sign) {
      edge.normalize();
      return Direction{static_cast<std::int32_t>(std::lround(-sign * edge.y() * 16384)),
                       static_cast<std::int32_t>(std::lround(sign * edge.x() * 16384))};
    };
    CornerFit fit;
    fit.corner.u = Pixel::from_real(at.x());
    fit.corner.v = Pixel::from_real(at.y());
    // Towards right-down the distance to the edge along 'right' is positive, to the edge along 'down' negative.
    fit.shape = {fit.corner.u, fit.corner.v, normal(right, 1), normal(down, bright ? -1 : 1), 4096};
    return fit;
  }
};

void expect_labelled(const SyntheticBoard& board, const CornerGrid& grid) {
  ASSERT_EQ(grid.rows, board.rows);
  ASSERT_EQ(grid.columns, board.columns);
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c) {
      const int index = grid.at(r, c);
      if (index < 0) continue;
      ASSERT_EQ(board.cells[static_cast<std::size_t>(index)], std::pair(r, c));
    }
}

TEST(GridLabelling, LabelsEveryCornerOfATurnedWavyBoard) {
  for (const double turn : {-0.6, -0.2, 0.0, 0.3, 0.7}) {
    SyntheticBoard board{9, 17, turn, 2e-4, 3, {}, {}};
    board.make(1);
    GridLabeller labeller(1000);
    const auto grid = labeller.label(board.corners);
    ASSERT_TRUE(grid.ok());
    EXPECT_TRUE(grid->complete());
    expect_labelled(board, *grid);
  }
}

TEST(GridLabelling, HolesDoNotShiftLabels) {
  SyntheticBoard board{9, 17, 0.2, 2e-4, 3, {}, {}};
  board.make(2);
  // A tenth of the corners is hidden, the frame of the board stays.
  SyntheticBoard rest = board;
  rest.corners.clear();
  rest.cells.clear();
  std::mt19937 random(3);
  for (std::size_t i = 0; i < board.corners.size(); ++i) {
    const auto [r, c] = board.cells[i];
    const bool inner = r > 0 && c > 0 && r < 8 && c < 16;
    if (inner && random() % 10 == 0) continue;
    rest.corners.push_back(board.corners[i]);
    rest.cells.push_back(board.cells[i]);
  }
  ASSERT_LT(rest.corners.size(), board.corners.size());
  GridLabeller labeller(1000);
  const auto grid = labeller.label(rest.corners);
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->found, static_cast<int>(rest.corners.size()));
  expect_labelled(rest, *grid);
}

TEST(GridLabelling, FalseCornersDoNotJoin) {
  SyntheticBoard board{7, 11, 0.1, 2e-4, 2, {}, {}};
  board.make(4);
  const std::size_t real = board.corners.size();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(0, 6.28);
  for (int k = 0; k < 12; ++k) {
    const double a = angle(random);
    board.corners.push_back(
        SyntheticBoard::corner({20.0 + 100 * k, 20}, {std::cos(a), std::sin(a)}, {-std::sin(a), std::cos(a)}, k % 2 == 0));
  }
  GridLabeller labeller(1000);
  const auto grid = labeller.label(board.corners);
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->found, static_cast<int>(real));
  expect_labelled(board, *grid);
}

TEST(GridLabelling, NeighboursMustAlternate) {
  SyntheticBoard board{5, 5, 0, 0, 0, {}, {}};
  board.make(6);
  for (CornerFit& fit : board.corners)
    if (!GridLabeller::bright_below_right(fit)) fit.shape.n2 = {-fit.shape.n2.x, -fit.shape.n2.y};
  GridLabeller labeller(100);
  const auto grid = labeller.label(board.corners);
  ASSERT_FALSE(grid.ok());
  EXPECT_EQ(grid.error(), Errc::kNotFound);
}

TEST(GridLabelling, SaysWhenThereIsNothingOrTooMuch) {
  GridLabeller labeller(10);
  EXPECT_EQ(labeller.label({}).error(), Errc::kNotFound);
  SyntheticBoard board{5, 5, 0, 0, 0, {}, {}};
  board.make(7);
  EXPECT_EQ(labeller.label(std::span(board.corners).first(1)).error(), Errc::kNotFound);
  EXPECT_EQ(labeller.label(board.corners).error(), Errc::kTooSmall);
}

// The corner at a cell, of the board's own polarity; away: how far from its place, in steps.
void add_corner(SyntheticBoard& board, int row, int column, const Eigen::Vector2d& away = {0, 0}) {
  const double r = row + away.y(), c = column + away.x();
  board.corners.push_back(SyntheticBoard::corner(board.project(r, c), board.project(r, c + 0.1) - board.project(r, c - 0.1),
                                                 board.project(r + 0.1, c) - board.project(r - 0.1, c),
                                                 (row + column) % 2 != 0));
  board.cells.emplace_back(row, column);
}

// Some corners of a board, by a rule on (row, column).
template <class Keep>
SyntheticBoard part_of(const SyntheticBoard& board, Keep&& keep) {
  SyntheticBoard part = board;
  part.corners.clear();
  part.cells.clear();
  for (std::size_t i = 0; i < board.corners.size(); ++i) {
    if (!keep(board.cells[i].first, board.cells[i].second)) continue;
    part.corners.push_back(board.corners[i]);
    part.cells.push_back(board.cells[i]);
  }
  return part;
}

TEST(GridLabelling, ABoardOfKnownSizeIsThatBoard) {
  for (const auto& [row, column] : {std::pair{3, 9}, std::pair{-1, 4}, std::pair{6, 0}, std::pair{2, -1}}) {
    SyntheticBoard board{6, 9, 0.15, 2e-4, 2, {}, {}};
    board.make(8);
    add_corner(board, row, column);  // as smooth as the board's own
    GridLabeller labeller(100);
    const auto any = labeller.label(board.corners);
    ASSERT_TRUE(any.ok());
    EXPECT_EQ(any->found, 55);
    const auto grid = labeller.label(board.corners, {6, 9});
    ASSERT_TRUE(grid.ok());
    EXPECT_TRUE(grid->complete());
    expect_labelled(board, *grid);
    // The next best place has lost a row of 9 or a column of 6 but for the extra corner.
    EXPECT_GT(grid->lead, 4);
  }
}

TEST(GridLabelling, TwoPlacesThatAreAlikeAreTold) {
  SyntheticBoard board{6, 10, 0.15, 2e-4, 2, {}, {}};
  board.make(9);
  GridLabeller labeller(100);
  const auto grid = labeller.label(board.corners, {6, 9});
  ASSERT_TRUE(grid.ok());
  EXPECT_TRUE(grid->complete());
  EXPECT_LT(grid->lead, 1);
}

TEST(GridLabelling, AGridSmallerThanTheBoardIsGivenAsItIs) {
  SyntheticBoard board{5, 9, 0.15, 2e-4, 2, {}, {}};
  board.make(9);
  GridLabeller labeller(100);
  const auto grid = labeller.label(board.corners, {6, 9});
  ASSERT_TRUE(grid.ok());
  expect_labelled(board, *grid);
  EXPECT_TRUE(grid->complete());
}

TEST(GridLabelling, CornersThatTheMapContradictsDoNotJoin) {
  for (const Eigen::Vector2d& away : {Eigen::Vector2d(0.25, 0), Eigen::Vector2d(-0.2, 0.15), Eigen::Vector2d(0, -0.3)}) {
    SyntheticBoard board{7, 11, 0.1, 2e-4, 2, {}, {}};
    board.make(10);
    const std::size_t real = board.corners.size();
    for (int column = 0; column < 11; column += 2) add_corner(board, -1, column, away);
    for (int row = 1; row < 7; row += 3) add_corner(board, row, 11, away);
    GridLabeller labeller(200);
    const auto grid = labeller.label(board.corners);
    ASSERT_TRUE(grid.ok());
    EXPECT_EQ(grid->found, static_cast<int>(real)) << away.transpose();
    expect_labelled(board, *grid);
  }
}

TEST(GridLabelling, TwoBoardsAreTwoGrids) {
  for (const double turn : {-0.6, 0.55, 0.75}) {
    SyntheticBoard left{5, 7, 0.1, 2e-4, 1, {}, {}}, right{6, 8, turn, 2e-4, 1, {}, {}};
    left.make(11);
    right.make(12);
    // Side by side, a little more than a square apart.
    double edge = 0, start = 1e9;
    for (const CornerFit& fit : left.corners) edge = std::max(edge, fit.corner.u.to<double>());
    for (const CornerFit& fit : right.corners) start = std::min(start, fit.corner.u.to<double>());
    std::vector<CornerFit> corners = left.corners;
    for (CornerFit fit : right.corners) {
      fit.corner.u = fit.shape.u = Pixel::from_real(fit.corner.u.to<double>() + edge + 45 - start);
      corners.push_back(fit);
    }
    GridLabeller labeller(200);
    ASSERT_TRUE(labeller.label(corners).ok());
    ASSERT_EQ(labeller.grids().size(), 2u) << turn;
    const CornerGrid &first = labeller.grids()[0], &second = labeller.grids()[1];
    EXPECT_EQ(first.found, 48);
    EXPECT_EQ(second.found, 35);
    EXPECT_TRUE(first.complete());
    EXPECT_TRUE(second.complete());
    for (const int cell : first.cells) EXPECT_GE(cell, 35);
    for (const int cell : second.cells) EXPECT_LT(cell, 35);
  }
}

TEST(GridLabelling, PartsJoinAcrossAMissingColumn) {
  SyntheticBoard board{9, 17, 0.2, 2e-4, 3, {}, {}};
  board.make(13);
  const SyntheticBoard parts = part_of(board, [](int, int column) { return column != 8; });
  GridLabeller labeller(200);
  const auto grid = labeller.label(parts.corners);
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->found, 9 * 16);
  EXPECT_EQ(labeller.grids().size(), 1u);
  expect_labelled(parts, *grid);
}

TEST(GridLabelling, PartsFarApartStayApart) {
  SyntheticBoard board{9, 17, 0.2, 2e-4, 3, {}, {}};
  board.make(14);
  const SyntheticBoard parts = part_of(board, [](int, int column) { return column < 5 || column > 10; });
  GridLabeller labeller(200);
  ASSERT_TRUE(labeller.label(parts.corners).ok());
  ASSERT_EQ(labeller.grids().size(), 2u);
  EXPECT_EQ(labeller.grids()[0].found, 9 * 6);
  EXPECT_EQ(labeller.grids()[1].found, 9 * 5);
}

// Two fits of one corner are one corner.
TEST(GridLabelling, ACornerFoundTwiceCountsOnce) {
  SyntheticBoard board{5, 7, 0.1, 2e-4, 1, {}, {}};
  board.make(15);
  const std::size_t real = board.corners.size();
  for (std::size_t i = 0; i < real; i += 3) {
    CornerFit again = board.corners[i];
    again.corner.u = Pixel::from_real(again.corner.u.to<double>() + 0.8);
    board.corners.push_back(again);
    board.cells.push_back(board.cells[i]);
  }
  GridLabeller labeller(100);
  const auto grid = labeller.label(board.corners);
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->found, static_cast<int>(real));
  expect_labelled(board, *grid);
}

}  // namespace
}  // namespace srd::dsp
