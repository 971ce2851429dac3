// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "host/run/pose_estimation.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::host::opensrd {
namespace {

// The flume's camera with another distortion, and the exact corners of its dry pattern.
struct DryView {
  Calibration calibration;
  dsp::View<double> view;
  Points points = board_points({11, 21}, 20);
  std::vector<dsp::Vec2<double>> pixels;

  explicit DryView(const std::vector<double>& distortion = {-0.21, 0.09, -0.004, -0.0035, 0.3}) {
    calibration.distortion = distortion;
    calibration.camera = dsp::CameraModel<double>::make(2150, 2156, 647, 315, distortion).value();
    view = fakes::look_at(calibration.camera, {-200, 250, 950}, {100, 200, 0});
    for (const auto& point : points) pixels.push_back(calibration.camera.pixel(view.normalised(point).value()));
  }
};

TEST(OpenSrdPose, ExactCornersGiveTheExactPose) {
  // The last one as real calibrations are: large rational coefficients that nearly cancel.
  const std::vector<std::vector<double>> distortions = {
      {0, 0, 0, 0},
      {-0.21, 0.09, -0.004, -0.0035, 0.3},
      {-0.2, 0.1, 1e-3, -1e-3, 0.1, 0.05, 0.02, 0.01},
      {900.2, 300.4, 1e-3, -1e-3, 10.5, 900.4, 490.3, 30.1, 1e-3, 0, -1e-3, 0, 0.01, -0.02}};
  for (const auto& distortion : distortions) {
    const DryView dry(distortion);
    const auto fit = fit_pose(dry.calibration, dry.pixels, dry.points, "ref.png");
    ASSERT_TRUE(fit) << fit.error().text();
    EXPECT_LT((fit->pose.centre() - dry.view.pose.centre()).norm(), 1e-4) << distortion.size();
    EXPECT_LT((fit->pose.rotation - dry.view.pose.rotation).norm(), 1e-7);
    EXPECT_LT(fit->rms_px, 1e-6);
    EXPECT_EQ(fit->corners, 231);
    EXPECT_TRUE(fit->warnings.empty());
  }
}

TEST(OpenSrdPose, BoardPointsRunDownXAndAlongY) {
  const Points points = board_points({3, 4}, 15);
  ASSERT_EQ(points.size(), 12U);
  EXPECT_EQ(points[1], dsp::Vec3<double>(0, 15, 0));
  EXPECT_EQ(points[4], dsp::Vec3<double>(15, 0, 0));
}

TEST(OpenSrdPose, PositionsTwoAndThreeSeeTheListFromItsEnd) {
  const Points points = board_points({3, 4}, 15);
  for (const int position : {1, 4}) EXPECT_EQ(seen_order(points, position).front(), points.front());
  for (const int position : {2, 3}) EXPECT_EQ(seen_order(points, position).front(), points.back());
  // A camera on the other side, whose image's first corner is the list's last.
  const DryView dry;
  const Eigen::AngleAxisd half_turn(fakes::kPi, dsp::Vec3<double>::UnitZ());
  dsp::View<double> other = dry.view;
  const dsp::Vec3<double> middle(100, 200, 0);
  other.pose.rotation = dry.view.pose.rotation * half_turn.toRotationMatrix().transpose();
  other.pose.translation = -(other.pose.rotation * (middle + half_turn * (dry.view.pose.centre() - middle)));
  std::vector<dsp::Vec2<double>> pixels;
  for (const auto& point : seen_order(dry.points, 3))
    pixels.push_back(dry.calibration.camera.pixel(other.normalised(point).value()));
  EXPECT_LT(pixels.front().x(), pixels.back().x());
  EXPECT_LT(pixels.front().y(), pixels.back().y());
  const auto fit = fit_pose(dry.calibration, pixels, seen_order(dry.points, 3), "ref.png");
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_LT((fit->pose.centre() - other.pose.centre()).norm(), 1e-4);
}

struct WrongPose {
  const char* what;
  void (*spoil)(DryView&);
  const char* expected;
};

class PoseFromWrongCorners : public testing::TestWithParam<WrongPose> {};

TEST_P(PoseFromWrongCorners, SaysWhatIsWrong) {
  DryView dry;
  GetParam().spoil(dry);
  const auto fit = fit_pose(dry.calibration, dry.pixels, dry.points, "ref.png");
  ASSERT_FALSE(fit) << GetParam().what;
  EXPECT_EQ(fit.error().exit, Exit::kInput);
  EXPECT_NE(fit.error().text().find("ref.png"), std::string::npos);
  EXPECT_NE(fit.error().text().find(GetParam().expected), std::string::npos) << fit.error().text();
}

INSTANTIATE_TEST_SUITE_P(OpenSrdPose, PoseFromWrongCorners,
                         testing::Values(WrongPose{"a corner less", [](DryView& d) { d.pixels.pop_back(); },
                                                   "230 corners and 231 points"},
                                         WrongPose{"three corners",
                                                   [](DryView& d) {
                                                     d.pixels.resize(3);
                                                     d.points.resize(3);
                                                   },
                                                   "at least 4"},
                                         WrongPose{"one row",
                                                   [](DryView& d) {
                                                     d.pixels.resize(21);
                                                     d.points.resize(21);
                                                   },
                                                   "one line"},
                                         WrongPose{"columns listed as rows",
                                                   [](DryView& d) {
                                                     d.points = board_points({21, 11}, 20);
                                                   },
                                                   "px rms"},
                                         WrongPose{"rows listed from the last",
                                                   [](DryView& d) {
                                                     Points mirrored;
                                                     for (int row = 10; row >= 0; --row)
                                                       mirrored.insert(mirrored.end(), d.points.begin() + 21 * row,
                                                                       d.points.begin() + 21 * (row + 1));
                                                     d.points = mirrored;
                                                   },
                                                   "mirrored"},
                                         WrongPose{"one wrong corner", [](DryView& d) { d.pixels[100].x() += 200; }, "px rms"},
                                         WrongPose{"not a number",
                                                   [](DryView& d) {
                                                     d.pixels[0] = {std::nan(""), 0};
                                                   },
                                                   "field of the calibration"}));

TEST(OpenSrdPose, PoorResidualsAreAWarning) {
  DryView dry;
  for (std::size_t i = 0; i < dry.pixels.size(); ++i) dry.pixels[i].x() += i % 2 == 0 ? 2.5 : -2.5;
  const auto fit = fit_pose(dry.calibration, dry.pixels, dry.points, "ref.png");
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_EQ(fit->warnings.size(), 1U);
}

TEST(OpenSrdPose, ColourOfTheFirstSquareFollowsFromAnyCorner) {
  const DryView dry;
  // X runs down and Y to the right: the square beyond the origin lies below right of its corner.
  for (std::size_t i = 0; i < dry.points.size(); ++i) {
    const bool odd = (i / 21 + i % 21) % 2 == 1;
    EXPECT_TRUE(first_square_bright({dry.pixels[i], !odd}, dry.points[i], 20, dry.view));
    EXPECT_FALSE(first_square_bright({dry.pixels[i], odd}, dry.points[i], 20, dry.view));
  }
}

TEST(OpenSrdPose, AnImageOfAnotherSizeIsRefused) {
  DryView dry;
  const std::vector<std::uint8_t> pixels(64 * 48);
  const GrayView image{pixels.data(), 64, 48, 64};
  EXPECT_TRUE(check_size(image, dry.calibration, "a.png"));  // the calibration says no size
  dry.calibration.image_width = 640;
  dry.calibration.image_height = 480;
  const auto wrong = check_size(image, dry.calibration, "a.png");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("640 x 480"), std::string::npos);
}

TEST(OpenSrdPose, AnImageWithoutABoardSaysHowManyCornersItHas) {
  const std::vector<std::uint8_t> pixels(320 * 200, 90);
  const auto none = find_board_corners({pixels.data(), 320, 200, 320}, {5, 17}, {}, "REF1.png");
  ASSERT_FALSE(none);
  const std::string text = none.error().text();
  for (const char* part : {"REF1.png", "5 rows of 17", "0 corners"}) EXPECT_NE(text.find(part), std::string::npos) << text;
}

}  // namespace
}  // namespace srd::host::opensrd
