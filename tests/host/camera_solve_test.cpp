// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "dsp/optics/camera_model.hpp"
#include "host/bundle/projection_uncertainty.hpp"
#include "tests/host/camera_draws.hpp"

namespace srd::bundle {
namespace {

std::vector<BoardView> views_of(const DrawnCamera& camera, int count, double noise_px, unsigned seed = 3) {
  std::mt19937 random(seed);
  return drawn_views(camera, drawn_poses(camera, count, 7), noise_px, random);
}

TEST(CameraSolve, FindsTheCameraThatDrewTheCorners) {
  DrawnCamera camera;
  camera.bend = {-0.1, 0.3};
  const auto fit = solve_camera(camera.board, views_of(camera, 12, 1e-6), camera.width, camera.height, {});
  ASSERT_TRUE(fit.ok()) << fit.error().text();
  for (std::size_t i = 0; i < camera.lens.size(); ++i)
    EXPECT_NEAR(fit->intrinsics[i], camera.lens[i], 1e-4 * (1 + std::abs(camera.lens[i])))
        << intrinsic_name(static_cast<int>(i));
  EXPECT_LT((fit->bend - camera.bend).norm(), 1e-5);
}

TEST(CameraSolve, IsTheOptimumOfOpenCV) {
  DrawnCamera camera;
  const auto views = views_of(camera, 15, 0.1);
  CameraOptions options;
  options.surface = Surface::kFlat;
  options.reject = 0;
  const auto fit = solve_camera(camera.board, views, camera.width, camera.height, options);
  ASSERT_TRUE(fit.ok());
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (const BoardView& view : views) {
    objects.emplace_back();
    images.emplace_back();
    for (const ViewCorner& corner : view.corners) {
      const Eigen::Vector3d p = camera.board.flat(corner.row, corner.column);
      objects.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
      images.back().emplace_back(static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y()));
    }
  }
  cv::Mat matrix, distortion;
  std::vector<cv::Mat> turns, translations;
  const double rms =
      cv::calibrateCamera(objects, images, {camera.width, camera.height}, matrix, distortion, turns, translations, 0,
                          cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-12));
  EXPECT_NEAR(fit->intrinsics[0], matrix.at<double>(0, 0), 0.1);
  EXPECT_NEAR(fit->intrinsics[1], matrix.at<double>(1, 1), 0.1);
  EXPECT_NEAR(fit->intrinsics[2], matrix.at<double>(0, 2), 0.1);
  EXPECT_NEAR(fit->intrinsics[3], matrix.at<double>(1, 2), 0.1);
  // OpenCV's is per corner, ours per axis; nobody may be better.
  EXPECT_NEAR(fit->rms_px * std::sqrt(2.0), rms, 1e-5);
}

TEST(CameraSolve, NamesTheCornersThatContradictTheOthers) {
  DrawnCamera camera;
  auto views = views_of(camera, 12, 0.03);
  std::mt19937 random(5);
  std::vector<std::pair<std::size_t, std::size_t>> spoilt;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const std::size_t c : {3 * v, 118 - v}) {
      views[v].corners[c].pixel += Eigen::Vector2d(v % 2 == 0 ? 5 : -0.8, 1.5);
      spoilt.emplace_back(v, c);
    }
  const auto fit = solve_camera(camera.board, views, camera.width, camera.height, {});
  ASSERT_TRUE(fit.ok());
  EXPECT_EQ(fit->rejected, static_cast<int>(spoilt.size()));
  for (const auto& [v, c] : spoilt) EXPECT_EQ(fit->views[v].used[c], 0) << v << " " << c;
  for (int i = 0; i < kPinhole; ++i)
    EXPECT_LT(std::abs(fit->intrinsics[static_cast<std::size_t>(i)] - camera.lens[static_cast<std::size_t>(i)]),
              4 * fit->deviation(i));
}

TEST(CameraSolve, DeviationsThatAreTooSmallGrowToTheResiduals) {
  DrawnCamera camera;
  auto views = views_of(camera, 15, 0.1);
  for (BoardView& view : views)
    for (ViewCorner& corner : view.corners) corner.sigma = 0.02;
  const auto fit = solve_camera(camera.board, views, camera.width, camera.height, {});
  ASSERT_TRUE(fit.ok());
  EXPECT_NEAR(std::hypot(0.02, fit->added_px), 0.1, 0.003);
  EXPECT_NEAR(fit->stated_ratio, 5, 0.15);
}

// Each view's corners share an error that its pose cannot take up: the stated errors must cover what that does.
TEST(SlowCameraSolve, ErrorsThatAViewsCornersShareWidenTheDeviations) {
  DrawnCamera camera;
  const auto poses = drawn_poses(camera, 15, 7);
  double normalised = 0;
  constexpr int kDraws = 12;
  for (unsigned draw = 0; draw < kDraws; ++draw) {
    std::mt19937 random(draw);
    std::normal_distribution<double> normal(0, 0.15);
    std::vector<BoardView> views;
    for (const PoseVector& pose : poses) {
      DrawnCamera flexed = camera;
      flexed.bend = {normal(random), normal(random)};
      views.push_back(drawn_views(flexed, {pose}, 0.02, random)[0]);
    }
    const auto fit = solve_camera(camera.board, views, camera.width, camera.height, {});
    ASSERT_TRUE(fit.ok());
    EXPECT_TRUE(fit->views_contradict);
    for (int i = 0; i < kPinhole; ++i) {
      const double error = fit->intrinsics[static_cast<std::size_t>(i)] - camera.lens[static_cast<std::size_t>(i)];
      normalised += error * error / (fit->covariance(i, i) * kPinhole * kDraws);
    }
  }
  // Without the widening it is 5 to 20.
  EXPECT_LT(normalised, 3);
  EXPECT_GT(normalised, 0.1);
}

TEST(CameraSolve, AFreeBoardIsFoundWhereItIsUneven) {
  DrawnCamera camera;
  const auto poses = drawn_poses(camera, 20, 7);
  std::mt19937 random(4);
  auto views = drawn_views(camera, poses, 0.02, random);
  // A dent of 0.2 mm round one corner.
  const auto dent = [](int row, int column) { return 0.2 * std::exp(-0.3 * (std::pow(row - 3, 2) + std::pow(column - 5, 2))); };
  for (std::size_t v = 0; v < views.size(); ++v) {
    const dsp::Pose<double> pose = to_pose(poses[v]);
    for (ViewCorner& corner : views[v].corners) {
      const Eigen::Vector3d flat = camera.board.flat(corner.row, corner.column);
      Eigen::Vector2d before, after;
      ASSERT_TRUE(project(camera.lens, pose.rotation * flat + pose.translation, before));
      ASSERT_TRUE(project(camera.lens,
                          pose.rotation * (flat + Eigen::Vector3d(0, 0, dent(corner.row, corner.column))) + pose.translation,
                          after));
      corner.pixel += after - before;
    }
  }
  CameraOptions options;
  options.surface = Surface::kFree;
  options.reject = 0;
  const auto fit = solve_camera(camera.board, views, camera.width, camera.height, options);
  ASSERT_TRUE(fit.ok()) << fit.error().text();
  // Against the plane through far corners: the pose may take up a tilt.
  const auto z = [&](int row, int column) { return fit->points[static_cast<std::size_t>(row * 17 + column)].z(); };
  const double rim = 0.25 * (z(0, 0) + z(6, 0) + z(0, 10) + z(6, 10));
  EXPECT_NEAR(z(3, 5) - rim, 0.2, 0.02);
  EXPECT_LT(fit->rms_px, 0.025);
}

TEST(CameraSolve, ViewsThatDoNotDetermineTheCameraAreRefused) {
  DrawnCamera camera;
  // The same square-on view again and again.
  std::vector<PoseVector> poses;
  for (int i = 0; i < 6; ++i) poses.push_back(drawn_poses(camera, 1, 7)[0]);
  for (PoseVector& pose : poses)
    pose = to_vector({(Eigen::Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished(), {-80, -30, 600}});
  std::mt19937 random(1);
  const auto views = drawn_views(camera, poses, 1e-7, random);
  const auto fit = solve_camera(camera.board, views, camera.width, camera.height, {});
  // Either it says so, or its stated error does.
  if (fit.ok()) {
    EXPECT_GT(fit->deviation(0) / fit->rms_px, 1e6);
  }
}

// mrcal's definition by brute force: perturb the corners, calibrate again, and see where a point lands.
TEST(SlowCameraUncertainty, IsTheScatterOfRepeatedCalibrations) {
  DrawnCamera camera;
  const auto poses = drawn_poses(camera, 10, 7);
  std::mt19937 random(11);
  const auto exact = drawn_views(camera, poses, 1e-9, random);
  auto views = exact;
  for (BoardView& view : views)
    for (ViewCorner& corner : view.corners) corner.sigma = 0.05;
  CameraOptions options;
  const auto truth = solve_camera(camera.board, views, camera.width, camera.height, options);
  ASSERT_TRUE(truth.ok());
  constexpr int kDraws = 150;
  const std::vector<Eigen::Vector2d> pixels{{960, 540}, {200, 150}, {1800, 900}};
  std::vector<Eigen::Matrix2d> scatter(pixels.size(), Eigen::Matrix2d::Zero());
  std::vector<double> stated(pixels.size(), 0);
  const auto model = dsp::CameraModel<double>::make(camera.lens[0], camera.lens[1], camera.lens[2], camera.lens[3],
                                                    std::span(camera.lens).subspan(kPinhole));
  for (int draw = 0; draw < kDraws; ++draw) {
    const auto noisy = drawn_views(camera, poses, 0.05, random);
    const auto fit = solve_camera(camera.board, noisy, camera.width, camera.height, options);
    ASSERT_TRUE(fit.ok());
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto ray = model->undistort(pixels[i]);
      const Eigen::Vector3d point = Eigen::Vector3d(ray->x(), ray->y(), 1).normalized() * 600;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (std::size_t v = 0; v < poses.size(); ++v) {
        const dsp::Pose<double> was = to_pose(poses[v]), is = to_pose(fit->views[v].pose);
        mean += (is.rotation * was.rotation.transpose() * (point - was.translation) + is.translation) /
                static_cast<double>(poses.size());
      }
      Eigen::Vector2d moved;
      ASSERT_TRUE(project(fit->intrinsics, mean, moved));
      scatter[i] += (moved - pixels[i]) * (moved - pixels[i]).transpose() / kDraws;
      stated[i] += projection_uncertainty(*fit, pixels[i].x(), pixels[i].y(), 600) / kDraws;
    }
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter[i]);
    EXPECT_NEAR(std::sqrt(axes.eigenvalues()[1]) / stated[i], 1, 0.2) << i;  // 150 draws: 6 % each way, the larger axis more
  }
}

}  // namespace
}  // namespace srd::bundle
