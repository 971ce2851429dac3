// SPDX-License-Identifier: Apache-2.0
// What srd calibrate says of views: refusals with advice, parts of boards, and the files that it writes.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/outputs.hpp"
#include "tests/host/camera_draws.hpp"

namespace srd::host {
namespace {

using bundle::BoardView;
using bundle::DrawnCamera;

std::vector<SightedBoard> sighted(const DrawnCamera& camera, const std::vector<BoardView>& views) {
  std::vector<SightedBoard> boards;
  for (const BoardView& view : views)
    boards.push_back({view.name, camera.width, camera.height, view, camera.board.rows, camera.board.columns, 200});
  return boards;
}

std::vector<BoardView> draw(const DrawnCamera& camera, int count, double noise_px = 0.05) {
  std::mt19937 random(9);
  return bundle::drawn_views(camera, bundle::drawn_poses(camera, count, 7), noise_px, random);
}

CalibratePlan plan_of(const DrawnCamera& camera) {
  CalibratePlan plan;
  plan.board = camera.board;
  return plan;
}

std::string refusal(const DrawnCamera& camera, std::vector<SightedBoard> boards) {
  const auto result = calibrate_boards(plan_of(camera), std::move(boards), {});
  return result ? "accepted" : result.error().text();
}

TEST(Calibrate, TooFewViewsAreRefused) {
  const DrawnCamera camera;
  EXPECT_NE(refusal(camera, sighted(camera, draw(camera, 3))).find("too few views"), std::string::npos);
}

TEST(Calibrate, MixedSizesAreNamed) {
  const DrawnCamera camera;
  auto boards = sighted(camera, draw(camera, 8));
  boards[3].width = 960;
  const std::string text = refusal(camera, std::move(boards));
  EXPECT_NE(text.find("images of different sizes"), std::string::npos) << text;
  EXPECT_NE(text.find("960 x 1080 px: 1 images, first view 4"), std::string::npos) << text;
}

TEST(Calibrate, HalfABoardIsRefusedWhereNoImageShowsItWhole) {
  const DrawnCamera camera;
  auto boards = sighted(camera, draw(camera, 8));
  for (SightedBoard& board : boards) {
    std::erase_if(board.view.corners, [](const auto& corner) { return corner.column >= 9; });
    board.columns = 9;
  }
  const std::string text = refusal(camera, std::move(boards));
  EXPECT_NE(text.find("no image shows the whole board"), std::string::npos) << text;
  EXPECT_NE(text.find("9 x 7"), std::string::npos) << text;
}

TEST(Calibrate, AFrontalBoardIsRefused) {
  const DrawnCamera camera;
  std::vector<bundle::PoseVector> poses;
  Eigen::Matrix3d facing;
  facing << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  for (int i = 0; i < 10; ++i) poses.push_back(bundle::to_vector({facing, {-90.0 + 7 * i, -30.0 - 2 * i, 600.0 + 10 * i}}));
  std::mt19937 random(2);
  const std::string text = refusal(camera, sighted(camera, bundle::drawn_views(camera, poses, 0.05, random)));
  EXPECT_TRUE(text.find("faces the camera") != std::string::npos || text.find("do not determine") != std::string::npos) << text;
  EXPECT_NE(text.find("tilt"), std::string::npos) << text;
}

TEST(Calibrate, ABoardThatIsSmallInTheImageIsRefused) {
  DrawnCamera camera;
  auto poses = bundle::drawn_poses(camera, 10, 7);
  for (auto& pose : poses) pose.tail<3>() *= 8;
  std::mt19937 random(2);
  const std::string text = refusal(camera, sighted(camera, bundle::drawn_views(camera, poses, 0.05, random)));
  EXPECT_NE(text.find("too small in every image"), std::string::npos) << text;
}

TEST(Calibrate, APartOfTheBoardServesAtItsPlace) {
  DrawnCamera camera;
  camera.bend = {0.1, 0.3};
  auto boards = sighted(camera, draw(camera, 12));
  // The last two show columns 6 to 16 and rows 2 to 6 only, counted from their own first corner.
  for (std::size_t i = 10; i < 12; ++i) {
    auto& corners = boards[i].view.corners;
    std::erase_if(corners, [](const auto& corner) { return corner.column < 6 || corner.row < 2; });
    for (auto& corner : corners) {
      corner.column -= 6;
      corner.row -= 2;
    }
    boards[i].rows = 5;
    boards[i].columns = 11;
  }
  const auto result = calibrate_boards(plan_of(camera), std::move(boards), {});
  ASSERT_TRUE(result.ok()) << result.error().text();
  ASSERT_EQ(result->views.size(), 12u);
  for (int i = 0; i < bundle::kPinhole; ++i)
    EXPECT_LT(std::abs(result->fit.intrinsics[static_cast<std::size_t>(i)] - camera.lens[static_cast<std::size_t>(i)]),
              4 * result->fit.deviation(i));
  EXPECT_NEAR(result->fit.bend.y(), 0.3, 4 * result->fit.deviation(result->fit.board_at() + 1));
  EXPECT_LT(result->fit.stated_ratio, 1.1);
}

// A flat board looks the same from a square on, so its views leave open where a part belongs; colours say by how much at least:
// a whole number of squares that keeps them.
TEST(Calibrate, APartOfAFlatBoardKeepsItsColours) {
  const DrawnCamera camera;
  auto boards = sighted(camera, draw(camera, 14));
  constexpr int kRow = 1, kColumn = 4;
  for (std::size_t i = 0; i < boards.size(); ++i) {
    boards[i].bright_first = true;
    if (i < 8) continue;
    auto& corners = boards[i].view.corners;
    std::erase_if(corners, [](const auto& corner) { return corner.column < kColumn || corner.row < kRow; });
    for (auto& corner : corners) {
      corner.column -= kColumn;
      corner.row -= kRow;
    }
    boards[i].rows -= kRow;
    boards[i].columns -= kColumn;
    boards[i].bright_first = false;
  }
  const auto result = calibrate_boards(plan_of(camera), std::move(boards), {});
  ASSERT_TRUE(result.ok()) << result.error().text();
  ASSERT_EQ(result->views.size(), 14u);
  for (std::size_t i = 8; i < 14; ++i) {
    int row = camera.board.rows, column = camera.board.columns;
    for (const auto& corner : result->views[i].corners) {
      row = std::min(row, corner.row);
      column = std::min(column, corner.column);
    }
    EXPECT_EQ((row + column) % 2, (kRow + kColumn) % 2) << result->views[i].name;
  }
}

TEST(Calibrate, TheNextViewTellsWhatItPromises) {
  const DrawnCamera camera;
  auto views = draw(camera, 8);
  const auto before = calibrate_boards(plan_of(camera), sighted(camera, views), {});
  ASSERT_TRUE(before.ok());
  ASSERT_GT(before->next.gain, 0);
  std::mt19937 random(3);
  views.push_back(bundle::drawn_views(camera, {before->next.pose}, 0.05, random)[0]);
  const auto after = calibrate_boards(plan_of(camera), sighted(camera, views), {});
  ASSERT_TRUE(after.ok());
  const auto volume = [](const CalibrationResult& result) {
    const int n = result.fit.lens_size(), at = result.fit.board_at();
    Eigen::MatrixXd shared(n + 2, n + 2);
    const auto place = [&](int i) { return i < n ? i : at + i - n; };
    for (int i = 0; i < n + 2; ++i)
      for (int j = 0; j < n + 2; ++j)
        shared(i, j) = result.fit.covariance(place(i), place(j)) / result.fit.variance_factor /
                       std::sqrt(result.fit.covariance(place(i), place(i)) * result.fit.covariance(place(j), place(j)));
    double logarithm = std::log(std::abs(shared.fullPivLu().determinant()));
    for (int i = 0; i < n + 2; ++i) logarithm += std::log(result.fit.covariance(place(i), place(i)));
    return logarithm / (2 * (n + 2));
  };
  EXPECT_NEAR(1 - std::exp(volume(*after) - volume(*before)), before->next.gain, 0.1);
}

TEST(Calibrate, EveryCornerAndParameterIsWritten) {
  const DrawnCamera camera;
  const auto result = calibrate_boards(plan_of(camera), sighted(camera, draw(camera, 12)), {});
  ASSERT_TRUE(result.ok()) << result.error().text();
  EXPECT_NE(report_toml(*result).find("fx = ["), std::string::npos);
  const std::string csv = corners_csv(*result);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 12 * camera.board.count());
}

}  // namespace
}  // namespace srd::host
