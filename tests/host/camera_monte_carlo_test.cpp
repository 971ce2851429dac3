// SPDX-License-Identifier: Apache-2.0
// Stated errors of a calibration against the scatter over draws whose truth is known.
#include <gtest/gtest.h>

#include <cmath>

#include "host/bundle/model_check.hpp"
#include "tests/host/camera_draws.hpp"

namespace srd::bundle {
namespace {

// 200 draws know a deviation to 5 %, 400 to 3.5 %: 10 % are then 2.8 of its own deviations.
constexpr int kCameraDraws = 400, kChecked = 200, kViews = 15;

// Of a mean of kCameraDraws chi-squares with n degrees, each divided by n: the normal limits of 99.9 %.
double interval(int n) { return 3.29 * std::sqrt(2.0 / (static_cast<double>(n) * kCameraDraws)); }

struct Scatter {
  Eigen::VectorXd error2, stated2;
  double normalised = 0;  // mean square of the errors in the metric of their covariance, a parameter
  int parameters = 0, contradicted = 0, misfit = 0;
  double worst_bend = 0;  // in stated deviations
};

Scatter draw(const DrawnCamera& camera, double noise_px, const CameraOptions& options, int draws = kCameraDraws) {
  const auto poses = drawn_poses(camera, kViews, 7);
  std::mt19937 random(static_cast<unsigned>(1000 * noise_px));
  Scatter scatter;
  for (int i = 0; i < draws; ++i) {
    const auto views = drawn_views(camera, poses, noise_px, random);
    const auto fit = solve_camera(camera.board, views, camera.width, camera.height, options);
    EXPECT_TRUE(fit.ok()) << fit.error().text();
    if (!fit) break;
    const int n = fit->lens_size(), at = fit->board_at(), all = n + (fit->surface == Surface::kBent ? kBend : 0);
    Eigen::VectorXd error(all);
    Eigen::MatrixXd spread(all, all);
    std::vector<int> rows;
    for (int j = 0; j < n; ++j) rows.push_back(j);
    for (int j = n; j < all; ++j) rows.push_back(at + j - n);
    for (int a = 0; a < all; ++a) {
      error[a] = a < n ? fit->intrinsics[static_cast<std::size_t>(a)] - camera.lens[static_cast<std::size_t>(a)]
                       : fit->bend[a - n] - camera.bend[a - n];
      for (int b = 0; b < all; ++b)
        spread(a, b) = fit->covariance(rows[static_cast<std::size_t>(a)], rows[static_cast<std::size_t>(b)]);
    }
    if (scatter.parameters == 0) scatter.error2 = scatter.stated2 = Eigen::VectorXd::Zero(all);
    scatter.parameters = all;
    scatter.error2 += error.cwiseAbs2() / draws;
    scatter.stated2 += spread.diagonal() / draws;
    scatter.normalised += error.dot(spread.ldlt().solve(error)) / (all * draws);
    for (int j = n; j < all; ++j)
      scatter.worst_bend = std::max(scatter.worst_bend, std::abs(error[j]) / std::sqrt(spread(j, j)));
    scatter.contradicted += fit->views_contradict ? 1 : 0;
    if (i < kChecked)
      scatter.misfit += check_model(camera.board, views, camera.width, camera.height, options, *fit).fits ? 0 : 1;
  }
  return scatter;
}

class CameraMonteCarlo : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(CameraMonteCarlo, StatedErrorsAreTheScatter) {
  const auto [noise_px, bend_mm] = GetParam();
  DrawnCamera camera;
  camera.bend = {0.4 * bend_mm, bend_mm};
  const Scatter scatter = draw(camera, noise_px, {});
  for (int i = 0; i < scatter.parameters; ++i)
    EXPECT_NEAR(std::sqrt(scatter.error2[i] / scatter.stated2[i]), 1, 0.1) << "parameter " << i;
  EXPECT_NEAR(scatter.normalised, 1, interval(scatter.parameters));
  // Of 800 numbers two lie beyond 3 deviations, none beyond 4.5.
  EXPECT_LT(scatter.worst_bend, 4.5);
  EXPECT_LE(scatter.contradicted, 1);
  EXPECT_LE(scatter.misfit, 2);
}

INSTANTIATE_TEST_SUITE_P(Slow, CameraMonteCarlo, ::testing::Combine(::testing::Values(0.02, 0.1), ::testing::Values(0.0, 0.3)));

class CameraMisfit : public ::testing::TestWithParam<double> {};

TEST_P(CameraMisfit, ABoardTakenForFlatIsTold) {
  DrawnCamera camera;
  camera.bend = {0.12, 0.3};
  CameraOptions flat;
  flat.surface = Surface::kFlat;
  EXPECT_GE(draw(camera, GetParam(), flat, kChecked).misfit, kChecked * 99 / 100);
}

INSTANTIATE_TEST_SUITE_P(Slow, CameraMisfit, ::testing::Values(0.02, 0.1));

}  // namespace
}  // namespace srd::bundle
