// SPDX-License-Identifier: Apache-2.0
// Boards photographed in real rooms: single public images, the count of inner corners in each file's name.
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/recording/image_file.hpp"
#include "dsp/frontend/board_finder.hpp"
#include "host/run/board_corners.hpp"
#include "tests/host/opensrd_folder.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

class PublicBoards : public testing::Test {
 protected:
  void SetUp() override {
    const auto root = lab_data();
    if (!root || !fs::is_directory(*root / "public-cases")) GTEST_SKIP() << "no public images: set SRD_DATA to their folder";
    folder = *root / "public-cases";
  }
  [[nodiscard]] GrayImage read(const std::string& name) const {
    auto image = read_gray_image(folder / name);
    EXPECT_TRUE(image.ok()) << (image ? "" : image.error().text());
    return image ? *image : GrayImage{};
  }
  fs::path folder;
};

dsp::Vec2<double> pixel_of(const dsp::BoardFinder& finder, int cell) {
  const dsp::Corner& corner = finder.corners()[static_cast<std::size_t>(cell)].corner;
  return {corner.u.to<double>(), corner.v.to<double>()};
}

// The largest bend of a grid's lines: a corner against the middle of its two neighbours, in steps.
double worst_bend(const dsp::BoardFinder& finder, const dsp::CornerGrid& grid) {
  double worst = 0;
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c)
      for (const auto& [dr, dc] : {std::pair{0, 1}, std::pair{1, 0}}) {
        if (r - dr < 0 || c - dc < 0 || r + dr >= grid.rows || c + dc >= grid.columns) continue;
        const int before = grid.at(r - dr, c - dc), here = grid.at(r, c), after = grid.at(r + dr, c + dc);
        if (before < 0 || here < 0 || after < 0) continue;
        const auto a = pixel_of(finder, before), b = pixel_of(finder, here), d = pixel_of(finder, after);
        worst = std::max(worst, (a + d - 2 * b).norm() / (d - a).norm());
      }
  return worst;
}

// Cells whose middle is bright where the grid's pattern says dark, or the other way. The corners' own edges are not used.
int wrong_cells(const GrayImage& image, const dsp::BoardFinder& finder, const dsp::CornerGrid& grid) {
  int cells[2] = {0, 0};
  for (int r = 0; r + 1 < grid.rows; ++r)
    for (int c = 0; c + 1 < grid.columns; ++c) {
      dsp::Vec2<double> middle(0, 0);
      double mean = 0;
      bool whole = true;
      for (const int cell : {grid.at(r, c), grid.at(r, c + 1), grid.at(r + 1, c), grid.at(r + 1, c + 1)}) {
        whole = whole && cell >= 0;
        if (!whole) break;
        middle += 0.25 * pixel_of(finder, cell);
        mean += 0.25 * finder.corners()[static_cast<std::size_t>(cell)].corner.mean;
      }
      if (!whole) continue;
      const int u = static_cast<int>(std::lround(middle.x())), v = static_cast<int>(std::lround(middle.y()));
      const bool bright = image.view().row(v)[u] > mean;
      ++cells[bright != (((r + c) & 1) != 0)];
    }
  return std::min(cells[0], cells[1]);
}

TEST_F(PublicBoards, ABoardOfKnownSizeIsFoundWhole) {
  struct Case {
    const char* name;
    PatternSize board;
  };
  for (const Case& at : {Case{"opencv-left05-54-corners.jpg", {9, 6}}, Case{"opencv-left06-crop-54-corners.png", {9, 6}},
                         Case{"gloworm-960x720-48-corners.jpg", {6, 8}}, Case{"underwater-0048-48-corners.png", {6, 8}},
                         Case{"underwater-0049-48-corners.png", {6, 8}}, Case{"picam-640x480-49-corners.jpg", {7, 7}},
                         Case{"picam-320x240-49-corners.jpg", {7, 7}}, Case{"lifecam-blurred-100-corners.png", {10, 10}}}) {
    SCOPED_TRACE(at.name);
    const GrayImage image = read(at.name);
    const auto corners = find_board_corners(image.view(), at.board, {5, 200, 8}, at.name);
    ASSERT_TRUE(corners.ok()) << corners.error().text();
    EXPECT_EQ(static_cast<int>(corners->size()), at.board.count());
    dsp::BoardFinder finder(image.width, image.height, 4000);
    const auto grid = finder.find(image.view(), {}, {at.board.rows, at.board.columns});
    ASSERT_TRUE(grid.ok());
    EXPECT_TRUE(grid->complete());
    EXPECT_LT(worst_bend(finder, *grid), 0.08);  // perspective and lens; a corner of something else is off by more
    EXPECT_GT(grid->lead, 4);
    EXPECT_EQ(wrong_cells(image, finder, *grid), 0);
  }
}

TEST_F(PublicBoards, SpreadInkIsJoined) {
  GrayImage image = read("ink-spread-77-corners.png");
  dsp::BoardFinder finder(image.width, image.height, 4000);
  auto grid = finder.find(image.view(), {}, {7, 11});
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->rows, 7);
  EXPECT_EQ(grid->columns, 11);
  EXPECT_GE(grid->found, 75);
  EXPECT_EQ(wrong_cells(image, finder, *grid), 0);
  for (std::uint8_t& level : image.pixels) level = static_cast<std::uint8_t>(std::min(255, 4 * level));
  grid = finder.find(image.view(), {});
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->rows, 7);
  EXPECT_EQ(grid->columns, 11);
  // All that are found are joined.
  EXPECT_EQ(grid->found, static_cast<int>(finder.corners().size()));
  EXPECT_GE(grid->found, 70);
  EXPECT_EQ(wrong_cells(image, finder, *grid), 0);
}

TEST_F(PublicBoards, SquaresOfSevenPixelsAreLabelled) {
  const GrayImage image = read("fcd-lab-7px-waves.png");
  dsp::BoardFinder finder(image.width, image.height, 16384);
  ASSERT_TRUE(finder.find(image.view(), {}).ok());
  int labelled = 0;
  for (const dsp::CornerGrid& grid : finder.grids()) {
    labelled += grid.found;
    EXPECT_EQ(wrong_cells(image, finder, grid), 0) << grid.found;
  }
  EXPECT_GE(labelled, 3924);  // 95 % of 4130
}

TEST_F(PublicBoards, ThreeBoardsAreThreeGrids) {
  const GrayImage image = read("three-boards.png");
  dsp::BoardFinder finder(image.width, image.height, 4000);
  ASSERT_TRUE(finder.find(image.view(), {}).ok());
  ASSERT_EQ(finder.grids().size(), 3u);
  for (const dsp::CornerGrid& grid : finder.grids()) {
    EXPECT_EQ(grid.rows, 5);
    EXPECT_EQ(grid.columns, 7);
    EXPECT_TRUE(grid.complete());
    EXPECT_LT(worst_bend(finder, grid), 0.08);
    EXPECT_EQ(wrong_cells(image, finder, grid), 0);
  }
}

// Corners beside the board that the detector finds in this image, u and v.
TEST_F(PublicBoards, ClutterOfABrokenWaterSurfaceDoesNotJoin) {
  const GrayImage image = read("ripple-calm.png");
  dsp::BoardFinder finder(image.width, image.height, 4000);
  const auto grid = finder.find(image.view(), {});
  ASSERT_TRUE(grid.ok());
  EXPECT_GE(grid->found, 135);
  constexpr double kClutter[][2] = {{59, 82},  {82, 64},   {84, 46},   {106, 35},  {109, 46}, {180, 29}, {234, 61},
                                    {272, 90}, {268, 114}, {281, 110}, {275, 131}, {29, 163}, {44, 206}};
  for (const int cell : grid->cells) {
    if (cell < 0) continue;
    const auto at = pixel_of(finder, cell);
    for (const auto& clutter : kClutter) EXPECT_GT(std::hypot(at.x() - clutter[0], at.y() - clutter[1]), 2.5) << at.transpose();
  }
  EXPECT_EQ(wrong_cells(image, finder, *grid), 0);
}

TEST_F(PublicBoards, GrowsAcrossHolesOfABrokenWaterSurface) {
  const GrayImage image = read("ripple-caustics.png");
  dsp::BoardFinder finder(image.width, image.height, 4000);
  const auto grid = finder.find(image.view(), {});
  ASSERT_TRUE(grid.ok());
  EXPECT_GE(grid->found, 80);
  int labelled = 0;
  for (const dsp::CornerGrid& each : finder.grids()) {
    labelled += each.found;
    EXPECT_EQ(wrong_cells(image, finder, each), 0);
  }
  EXPECT_GE(labelled, 98);
}

}  // namespace
}  // namespace srd::host
