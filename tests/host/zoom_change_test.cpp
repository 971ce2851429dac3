// SPDX-License-Identifier: Apache-2.0
// Sets of views whose zoom or focus was changed among them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "host/bundle/zoom_change.hpp"
#include "host/calibrate/calibration.hpp"
#include "tests/host/camera_draws.hpp"

namespace srd::host {
namespace {

using bundle::BoardView;
using bundle::DrawnCamera;

constexpr int kViews = 14;

// The first so many with the camera, the others with one whose focal length is longer by this part. A new focus also moves the
// principal point and the distortion.
std::vector<BoardView> changed_views(std::size_t before, double part, double noise_px, std::mt19937& random) {
  const DrawnCamera camera;
  DrawnCamera changed = camera;
  changed.lens[0] *= 1 + part;
  changed.lens[1] *= 1 + part;
  changed.lens[2] += 200 * part;
  changed.lens[4] *= 1 + part;
  const auto poses = bundle::drawn_poses(camera, kViews, 7);
  auto views = bundle::drawn_views(camera, poses, noise_px, random);
  const auto others = bundle::drawn_views(changed, poses, noise_px, random);
  std::copy(others.begin() + static_cast<std::ptrdiff_t>(before), others.end(),
            views.begin() + static_cast<std::ptrdiff_t>(before));
  return views;
}

std::optional<bundle::ZoomChange> change_in(const std::vector<BoardView>& views) {
  const DrawnCamera camera;
  const auto fit = bundle::solve_camera(camera.board, views, camera.width, camera.height, {});
  EXPECT_TRUE(fit.ok()) << fit.error().text();
  std::vector<std::size_t> order(views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  return bundle::find_zoom_change(camera.board, views, *fit, order);
}

std::vector<SightedBoard> boards_of(const std::vector<BoardView>& views) {
  const DrawnCamera camera;
  std::vector<SightedBoard> boards;
  for (const BoardView& view : views)
    boards.push_back({view.name, camera.width, camera.height, view, camera.board.rows, camera.board.columns, 200});
  return boards;
}

std::string refusal(std::vector<SightedBoard> boards) {
  CalibratePlan plan;
  plan.board = DrawnCamera{}.board;
  const auto result = calibrate_boards(plan, std::move(boards), {});
  return result ? "accepted" : result.error().text();
}

TEST(ZoomChange, IsRefusedWithTheImageItBeginsAtAndItsSize) {
  std::mt19937 random(4);
  int exact = 0;
  for (const std::size_t before : {std::size_t{4}, std::size_t{7}, std::size_t{11}})
    for (const double part : {0.005, -0.02, 0.1}) {
      const std::string text = refusal(boards_of(changed_views(before, part, 0.05, random)));
      EXPECT_NE(text.find("zoom or focus was changed among the images"), std::string::npos) << part << ": " << text;
      const std::string::size_type at = text.find("from about view ");
      ASSERT_NE(at, std::string::npos) << part << " before " << before << ": " << text;
      int view = 0;
      double said = 0;
      ASSERT_EQ(std::sscanf(text.c_str() + at, "from about view %d on the focal length is %lf %%", &view, &said), 2) << text;
      // A view that faces the camera does not tell the focal length: it may be counted to either side.
      EXPECT_NEAR(view, static_cast<int>(before) + 1, 1) << text;
      exact += view == static_cast<int>(before) + 1 ? 1 : 0;
      // To first order.
      EXPECT_NEAR(said, 100 * std::abs(part), 0.1 + 100 * std::abs(part) * (0.1 + 3 * std::abs(part))) << text;
      EXPECT_NE(text.find(part > 0 ? "longer" : "shorter"), std::string::npos) << text;
    }
  EXPECT_GE(exact, 7);
}

TEST(ZoomChange, AFewImagesOfQuiteAnotherZoomAreLeftOutAndNamed) {
  std::mt19937 random(4);
  CalibratePlan plan;
  plan.board = DrawnCamera{}.board;
  const auto result = calibrate_boards(plan, boards_of(changed_views(12, 0.3, 0.05, random)), {});
  if (!result) {
    EXPECT_NE(result.error().text().find("zoom or focus was changed"), std::string::npos) << result.error().text();
    return;
  }
  EXPECT_LT(std::abs(result->fit.intrinsics[0] - 3700), 4 * result->fit.deviation(0));
  for (const char* view : {"view 13 contradicts the other images", "view 14 contradicts the other images"})
    EXPECT_TRUE(std::any_of(result->warnings.begin(), result->warnings.end(), [&](const std::string& warning) {
      return warning.find(view) == 0;
    })) << view;
}

TEST(ZoomChange, FollowsTheOrderOfTheImagesAlsoWhereSomeShowAPartOnly) {
  std::mt19937 random(4);
  auto boards = boards_of(changed_views(7, 0.01, 0.05, random));
  // A part goes behind the whole boards in the adjustment: it must not be taken for the last image.
  auto& corners = boards[2].view.corners;
  std::erase_if(corners, [](const auto& corner) { return corner.column < 4; });
  for (auto& corner : corners) corner.column -= 4;
  boards[2].columns -= 4;
  const std::string text = refusal(std::move(boards));
  const std::string::size_type at = text.find("from about view ");
  ASSERT_NE(at, std::string::npos) << text;
  int view = 0;
  double said = 0;
  ASSERT_EQ(std::sscanf(text.c_str() + at, "from about view %d on the focal length is %lf %%", &view, &said), 2) << text;
  EXPECT_NEAR(view, 8, 1) << text;  // as above
  EXPECT_NEAR(said, 1, 0.2) << text;
}

TEST(ZoomChange, OfOneCameraIsNoneAndTheCalibrationIsAccepted) {
  std::mt19937 random(4);
  for (const double noise_px : {0.02, 0.3})
    EXPECT_EQ(refusal(boards_of(changed_views(kViews, 0, noise_px, random))), "accepted");
}

// 60 sets: at a false alarm in 1000, two or more have a probability of 0.002.
TEST(ZoomChange, IsSeldomSeenWhereThereIsNone) {
  std::mt19937 random(12);
  int alarms = 0;
  double worst = 0, sum = 0;
  constexpr int kSets = 60;
  for (int set = 0; set < kSets; ++set) {
    const auto change = change_in(changed_views(kViews, 0, 0.1, random));
    ASSERT_TRUE(change);
    alarms += change->found() ? 1 : 0;
    worst = std::max(worst, change->chi_square);
    sum += change->chi_square;
  }
  std::printf("  %d alarms in %d sets, chi-square %.1f on average, %.1f at most\n", alarms, kSets, sum / kSets, worst);
  EXPECT_LE(alarms, 1);
  // The largest of 9 that depend on each other: more than one alone, less than of 9 that do not.
  EXPECT_GT(sum / kSets, 1.0);
  EXPECT_LT(sum / kSets, 4.5);
}

// 400 sets: at a false alarm in 1000, more than two have a probability of 0.008.
TEST(SlowZoomChange, FalseAlarmsAreAsRareAsStatedAndErrorsAsLarge) {
  std::mt19937 random(13);
  constexpr int kSets = 400, kChanged = 200;
  constexpr double kPart = 0.01;
  int alarms = 0, found = 0;
  for (int set = 0; set < kSets; ++set) alarms += change_in(changed_views(kViews, 0, 0.1, random))->found() ? 1 : 0;
  double squares = 0, stated = 0;
  for (int set = 0; set < kChanged; ++set) {
    const auto change = change_in(changed_views(7, kPart, 0.1, random));
    ASSERT_TRUE(change);
    if (!change->found() || change->from != 7) continue;
    ++found;
    squares += (change->part - kPart) * (change->part - kPart);
    stated += change->deviation * change->deviation;
  }
  std::printf("  %d alarms in %d sets; %d of %d changes found at their place, errors %.2f of the stated\n", alarms, kSets,
              found, kChanged, std::sqrt(squares / stated));
  EXPECT_LE(alarms, 2);
  EXPECT_GE(found, kChanged * 8 / 10);
  // The larger one of two errors is stated: never too small.
  EXPECT_LT(std::sqrt(squares / stated), 1.1);
  EXPECT_GT(std::sqrt(squares / stated), 0.5);
}

}  // namespace
}  // namespace srd::host
