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
    for (const auto& [r, c] : cells) corners.push_back(corner(project(r, c), project(r, c + 0.1) - project(r, c - 0.1),
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
    board.corners.push_back(SyntheticBoard::corner({20.0 + 100 * k, 20}, {std::cos(a), std::sin(a)},
                                                   {-std::sin(a), std::cos(a)}, k % 2 == 0));
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

}  // namespace
}  // namespace srd::dsp
