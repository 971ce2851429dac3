// SPDX-License-Identifier: Apache-2.0
// Boards photographed in real rooms: single public images, the count of inner corners in each file's name.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <span>

#include <Eigen/Dense>

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

// A crest squeezes the squares to four pixels. What lies on both its sides is one board, on one grid: wherever waves may move
// them, corners stay where the plane through all of them has them, to a square and a half; a grid that is out of step by one
// square along rows and columns is off by as much in one half of the image more than in the other.
TEST_F(PublicBoards, SquaresOfSevenPixelsUnderWavesAreOneGrid) {
  const GrayImage image = read("fcd-lab-7px-waves.png");
  dsp::BoardFinder finder(image.width, image.height, 16384);
  const auto grid = finder.find(image.view(), {});
  ASSERT_TRUE(grid.ok());
  EXPECT_GE(grid->found, 3924);  // 95 % of 4130
  EXPECT_EQ(wrong_cells(image, finder, *grid), 0);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  const auto visit = [&](auto&& act) {
    for (int r = 0; r < grid->rows; ++r)
      for (int c = 0; c < grid->columns; ++c)
        if (grid->at(r, c) >= 0) act(Eigen::Vector3d(1, r, c), pixel_of(finder, grid->at(r, c)));
  };
  visit([&](const Eigen::Vector3d& at, const dsp::Vec2<double>& pixel) {
    normal += at * at.transpose();
    right += at * pixel.transpose();
  });
  const Eigen::Matrix<double, 3, 2> plane = normal.ldlt().solve(right);
  visit([&](const Eigen::Vector3d& at, const dsp::Vec2<double>& pixel) {
    EXPECT_LT((plane.transpose() * at - pixel).norm(), 1.5 * 6.9) << at.transpose();
  });
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

// What a person sees at enlarged crops: row and column of each corner, counted from one to the next over squares that are in
// view, and its pixel.
struct SeenCorner {
  int row, column, u, v;
};

struct Agreement {
  int right = 0, wrong = 0, unseen = 0;  // cells of the grid that are the seen corner's, another's, and none that was seen
};

Agreement compare(const dsp::BoardFinder& finder, const dsp::CornerGrid& grid, std::span<const SeenCorner> seen) {
  constexpr double kSame = 3;  // px
  const auto at = [&](int cell) -> const SeenCorner* {
    const auto pixel = pixel_of(finder, cell);
    for (const SeenCorner& corner : seen)
      if (std::hypot(pixel.x() - corner.u, pixel.y() - corner.v) < kSame) return &corner;
    return nullptr;
  };
  // A grid counts from its own first corner: the shift that most of its cells have.
  std::map<std::pair<int, int>, int> shifts;
  Agreement agreement;
  int all = 0;
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c) {
      if (grid.at(r, c) < 0) continue;
      ++all;
      if (const SeenCorner* corner = at(grid.at(r, c)))
        ++shifts[{corner->row - r, corner->column - c}];
      else
        ++agreement.unseen;
    }
  for (const auto& [shift, count] : shifts) agreement.right = std::max(agreement.right, count);
  agreement.wrong = all - agreement.unseen - agreement.right;
  return agreement;
}

// A calm disc of board amid a broken surface, which shows pieces of board too: none of these joins.
TEST_F(PublicBoards, ClutterOfABrokenWaterSurfaceDoesNotJoin) {
  constexpr SeenCorner kSeen[] = {
      {0, 5, 86, 71},     {0, 6, 99, 63},     {0, 7, 114, 56},    {0, 8, 129, 49},   {1, 3, 61, 100},   {1, 4, 75, 93},
      {1, 5, 91, 86},     {1, 6, 106, 78},    {1, 7, 122, 71},    {1, 8, 136, 64},   {1, 9, 152, 56},   {1, 10, 168, 48},
      {1, 11, 181, 41},   {2, 2, 54, 125},    {2, 3, 68, 116},    {2, 4, 83, 108},   {2, 5, 98, 101},   {2, 6, 114, 94},
      {2, 7, 129, 86},    {2, 8, 144, 79},    {2, 9, 160, 71},    {2, 10, 175, 63},  {2, 11, 190, 57},  {2, 12, 205, 51},
      {3, 1, 46, 147},    {3, 2, 60, 139},    {3, 3, 75, 131},    {3, 4, 91, 124},   {3, 5, 106, 117},  {3, 6, 122, 109},
      {3, 7, 137, 102},   {3, 8, 152, 94},    {3, 9, 167, 87},    {3, 10, 182, 79},  {3, 11, 198, 72},  {3, 12, 214, 64},
      {4, 0, 40, 171},    {4, 1, 53, 162},    {4, 2, 67, 154},    {4, 3, 82, 147},   {4, 4, 99, 139},   {4, 5, 114, 132},
      {4, 6, 129, 124},   {4, 7, 144, 117},   {4, 8, 159, 110},   {4, 9, 174, 102},  {4, 10, 190, 95},  {4, 11, 205, 86},
      {4, 12, 220, 79},   {4, 13, 234, 71},   {5, 0, 47, 185},    {5, 1, 59, 178},   {5, 2, 74, 170},   {5, 3, 90, 162},
      {5, 4, 106, 155},   {5, 5, 121, 147},   {5, 6, 136, 140},   {5, 7, 152, 132},  {5, 8, 167, 125},  {5, 9, 182, 117},
      {5, 10, 197, 110},  {5, 11, 212, 102},  {5, 12, 227, 95},   {5, 13, 242, 88},  {6, 0, 51, 201},   {6, 1, 66, 193},
      {6, 2, 82, 185},    {6, 3, 98, 178},    {6, 4, 113, 170},   {6, 5, 129, 162},  {6, 6, 144, 155},  {6, 7, 159, 147},
      {6, 8, 174, 140},   {6, 9, 189, 133},   {6, 10, 204, 125},  {6, 11, 220, 118}, {6, 12, 235, 110}, {6, 13, 251, 103},
      {7, 0, 58, 214},    {7, 1, 74, 208},    {7, 2, 89, 201},    {7, 3, 105, 193},  {7, 4, 120, 185},  {7, 5, 136, 177},
      {7, 6, 151, 170},   {7, 7, 167, 162},   {7, 8, 182, 155},   {7, 9, 197, 148},  {7, 10, 212, 140}, {7, 11, 227, 133},
      {7, 12, 243, 125},  {7, 13, 258, 117},  {8, 1, 82, 223},    {8, 2, 97, 216},   {8, 3, 112, 208},  {8, 4, 128, 200},
      {8, 5, 143, 193},   {8, 6, 159, 185},   {8, 7, 174, 177},   {8, 8, 189, 170},  {8, 9, 204, 163},  {8, 10, 219, 155},
      {8, 11, 235, 148},  {8, 12, 251, 141},  {8, 13, 265, 134},  {9, 1, 90, 239},   {9, 2, 105, 232},  {9, 3, 120, 225},
      {9, 4, 135, 216},   {9, 5, 151, 208},   {9, 6, 166, 200},   {9, 7, 181, 193},  {9, 8, 196, 185},  {9, 9, 212, 178},
      {9, 10, 227, 170},  {9, 11, 243, 164},  {9, 12, 259, 157},  {10, 1, 99, 255},  {10, 2, 113, 248}, {10, 3, 127, 241},
      {10, 4, 143, 233},  {10, 5, 158, 225},  {10, 6, 173, 216},  {10, 7, 189, 208}, {10, 8, 204, 201}, {10, 9, 220, 193},
      {10, 10, 236, 186}, {10, 11, 252, 179}, {10, 12, 267, 172}, {11, 2, 119, 263}, {11, 3, 134, 256}, {11, 4, 150, 248},
      {11, 5, 166, 240},  {11, 6, 181, 233},  {11, 7, 196, 225},  {11, 8, 211, 217}, {11, 9, 227, 208}, {11, 10, 244, 201},
      {11, 11, 259, 193}, {12, 3, 141, 272},  {12, 4, 157, 262},  {12, 5, 173, 255}, {12, 6, 189, 248}, {12, 7, 203, 241},
      {12, 8, 218, 232},  {12, 9, 234, 223},  {12, 10, 250, 214}, {13, 6, 198, 265}, {13, 7, 210, 257}, {13, 8, 225, 247}};
  const GrayImage image = read("ripple-calm.png");
  dsp::BoardFinder finder(image.width, image.height, 4000);
  const auto grid = finder.find(image.view(), {});
  ASSERT_TRUE(grid.ok());
  const Agreement agreement = compare(finder, *grid, kSeen);
  EXPECT_EQ(agreement.wrong, 0);
  EXPECT_EQ(agreement.unseen, 0);
  EXPECT_GE(agreement.right, 0.95 * std::size(kSeen));
  EXPECT_EQ(finder.grids().size(), 1u);
  EXPECT_EQ(wrong_cells(image, finder, *grid), 0);
}

// Ripples round a calm middle fold the image of the board: between it and what goes on outside corners are necks of two
// squares or not to be seen. All that are labelled are on one grid and right.
TEST_F(PublicBoards, GrowsAcrossHolesOfABrokenWaterSurface) {
  constexpr SeenCorner kSeen[] = {
      {0, 6, 109, 45},   {1, 3, 63, 85},    {1, 4, 82, 77},    {1, 5, 101, 70},   {1, 6, 120, 64},   {1, 7, 136, 57},
      {1, 8, 152, 48},   {2, 2, 56, 109},   {2, 3, 73, 102},   {2, 4, 97, 98},    {2, 5, 114, 91},   {2, 6, 130, 84},
      {2, 7, 145, 76},   {2, 8, 160, 68},   {2, 9, 176, 59},   {2, 10, 192, 45},  {3, 1, 48, 137},   {3, 2, 65, 128},
      {3, 3, 90, 121},   {3, 4, 107, 114},  {3, 5, 122, 107},  {3, 6, 138, 100},  {3, 7, 152, 92},   {3, 8, 168, 84},
      {3, 9, 183, 76},   {3, 10, 199, 67},  {4, 1, 56, 155},   {4, 2, 78, 146},   {4, 3, 99, 137},   {4, 4, 114, 130},
      {4, 5, 129, 122},  {4, 6, 145, 115},  {4, 7, 160, 108},  {4, 8, 175, 100},  {4, 9, 190, 92},   {4, 10, 206, 84},
      {4, 11, 228, 70},  {5, 0, 45, 183},   {5, 1, 63, 173},   {5, 2, 87, 162},   {5, 3, 107, 152},  {5, 4, 122, 145},
      {5, 5, 137, 137},  {5, 6, 152, 130},  {5, 7, 167, 123},  {5, 8, 182, 115},  {5, 9, 197, 108},  {5, 10, 213, 100},
      {5, 11, 231, 91},  {6, 0, 52, 198},   {6, 1, 70, 189},   {6, 2, 96, 177},   {6, 3, 114, 167},  {6, 4, 129, 160},
      {6, 5, 144, 152},  {6, 6, 160, 145},  {6, 7, 175, 138},  {6, 8, 190, 131},  {6, 9, 205, 123},  {6, 10, 220, 116},
      {6, 11, 238, 107}, {6, 12, 262, 98},  {7, -1, 49, 221},  {7, 0, 61, 213},   {7, 1, 79, 206},   {7, 2, 101, 196},
      {7, 3, 121, 182},  {7, 4, 137, 175},  {7, 5, 152, 167},  {7, 6, 167, 160},  {7, 7, 182, 153},  {7, 8, 197, 146},
      {7, 9, 212, 138},  {7, 10, 228, 131}, {7, 11, 251, 124}, {7, 12, 271, 115}, {8, 0, 71, 228},   {8, 1, 89, 222},
      {8, 2, 106, 215},  {8, 3, 128, 199},  {8, 4, 144, 190},  {8, 5, 160, 183},  {8, 6, 175, 175},  {8, 7, 190, 168},
      {8, 8, 205, 160},  {8, 9, 220, 153},  {8, 10, 236, 146}, {8, 11, 266, 141}, {9, 0, 83, 248},   {9, 1, 98, 240},
      {9, 2, 115, 232},  {9, 3, 134, 222},  {9, 4, 151, 207},  {9, 5, 167, 198},  {9, 6, 182, 191},  {9, 7, 197, 183},
      {9, 8, 212, 176},  {9, 9, 229, 169},  {9, 10, 256, 165}, {9, 11, 275, 157}, {10, 1, 107, 256}, {10, 2, 124, 249},
      {10, 3, 141, 241}, {10, 4, 159, 233}, {10, 5, 176, 220}, {10, 8, 226, 196}, {10, 9, 246, 191}, {10, 10, 265, 182},
      {11, 2, 131, 267}, {11, 3, 150, 258}, {11, 4, 168, 250}, {11, 5, 185, 243}, {11, 6, 202, 234}, {11, 7, 219, 225},
      {11, 8, 236, 216}, {11, 9, 255, 207}, {12, 3, 159, 274}, {12, 4, 179, 267}, {12, 5, 194, 261}, {12, 6, 209, 252},
      {12, 7, 226, 242}, {12, 8, 244, 232}, {13, 6, 218, 266}};
  const GrayImage image = read("ripple-caustics.png");
  dsp::BoardFinder finder(image.width, image.height, 4000);
  const auto grid = finder.find(image.view(), {});
  ASSERT_TRUE(grid.ok());
  const Agreement agreement = compare(finder, *grid, kSeen);
  EXPECT_EQ(agreement.wrong, 0);
  EXPECT_EQ(agreement.unseen, 0);
  EXPECT_GE(agreement.right, 108);
  EXPECT_EQ(finder.grids().size(), 1u);
  EXPECT_EQ(wrong_cells(image, finder, *grid), 0);
}

}  // namespace
}  // namespace srd::host
