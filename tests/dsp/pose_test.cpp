// SPDX-License-Identifier: Apache-2.0
// Poses from corners: derivatives, errors that are true, and moves that are told.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "drivers/camera/simulator/scene.hpp"
#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/pose/height_of_pose.hpp"
#include "dsp/pose/pose_check.hpp"
#include "dsp/pose/pose_comparison.hpp"
#include "dsp/pose/systematic_watch.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

// The simulator's flume, dry or under water with a wave.
struct PosedFlume {
  Scene scene = default_scene();
  View<double> view = scene.view();
  Points points = scene.points();
  std::mt19937 random{7};

  [[nodiscard]] WaterAbove water(const ModeList& modes, const Coefficients<double>& a) const {
    SurfaceModel<double> model = scene.surface;
    model.modes = modes;
    return {model, a, scene.media};
  }
  [[nodiscard]] WaterAbove still(double level) const {
    return water(ModeList::standard(1).value(), fakes::coefficients({level}));
  }
  [[nodiscard]] std::vector<Vec2<double>> pixels(const View<double>& from, const WaterAbove* above) const {
    std::vector<Vec2<double>> all;
    for (const auto& point : points) all.push_back(see_point(from, point, above)->pixel);
    return all;
  }
  // Every fifth corner is enough where many draws are made.
  void thin_out() {
    Points kept;
    for (std::size_t i = 0; i < points.size(); i += 5) kept.push_back(points[i]);
    points = kept;
  }
  [[nodiscard]] Vec2<double> noise(double sigma) {
    std::normal_distribution<double> normal(0, sigma);
    const double u = normal(random);
    return {u, normal(random)};
  }
  [[nodiscard]] std::vector<PoseCorner> noisy(const std::vector<Vec2<double>>& exact, double sigma) {
    std::vector<PoseCorner> corners;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      // Corners are not all alike: their deviations differ by a factor of three.
      const double own = sigma * (0.5 + static_cast<double>(i % 5) / 4);
      corners.push_back({points[i], exact[i] + noise(own), own});
    }
    return corners;
  }
  [[nodiscard]] std::vector<CornerPair> pairs(const View<double>& later, double sigma) {
    const auto before = pixels(view, nullptr), after = pixels(later, nullptr);
    std::vector<CornerPair> all;
    for (std::size_t i = 0; i < points.size(); ++i)
      all.push_back({points[i], before[i] + noise(sigma), after[i] + noise(1.5 * sigma), sigma, 1.5 * sigma});
    return all;
  }
};

PoseChange unit_change(int axis, double size) { return size * PoseChange::Unit(axis); }

TEST(PoseFit, DerivativesAgreeWithCentralDifferences) {
  const PosedFlume flume;
  WaterAbove wave = flume.water(ModeList::standard(5).value(), fakes::wavy(5));
  wave.media.layers[0] = {10, 1.49};
  wave.media.n_layers = 1;
  const WaterAbove* media[] = {nullptr, &wave};
  for (const WaterAbove* above : media)
    for (const std::size_t i : {std::size_t{0}, std::size_t{100}, flume.points.size() - 1}) {
      const auto seen = see_point(flume.view, flume.points[i], above);
      ASSERT_TRUE(seen);
      for (int axis = 0; axis < 6; ++axis) {
        const double step = axis < 3 ? 1e-5 : 1e-2;
        View<double> more = flume.view, less = flume.view;
        more.pose = changed(flume.view.pose, unit_change(axis, step));
        less.pose = changed(flume.view.pose, unit_change(axis, -step));
        const Vec2<double> difference =
            (see_point(more, flume.points[i], above)->pixel - see_point(less, flume.points[i], above)->pixel) / (2 * step);
        EXPECT_LT((seen->by_pose.col(axis) - difference).norm(), 1e-5 * (1 + difference.norm())) << axis;
      }
      if (above == nullptr) continue;
      Basis<double> basis;
      above->model.basis(seen->foot.x(), seen->foot.y(), basis);
      for (int j = 0; j < 5; ++j) {
        WaterAbove more = *above, less = *above;
        more.surface[j] += 1e-3;
        less.surface[j] -= 1e-3;
        const Vec2<double> difference =
            (see_point(flume.view, flume.points[i], &more)->pixel - see_point(flume.view, flume.points[i], &less)->pixel) /
            2e-3;
        const Vec2<double> ours = seen->by_height * basis.value[j] + seen->by_slope * Vec2<double>(basis.dx[j], basis.dy[j]);
        EXPECT_LT((ours - difference).norm(), 1e-5 * (1 + difference.norm())) << j;
      }
    }
}

TEST(PoseFit, ExactCornersGiveTheExactPoseDryAndThroughWater) {
  PosedFlume flume;
  const WaterAbove still = flume.still(80);
  const WaterAbove* media[] = {nullptr, &still};
  for (const WaterAbove* above : media) {
    std::vector<PoseCorner> corners;
    const auto exact = flume.pixels(flume.view, above);
    for (std::size_t i = 0; i < exact.size(); ++i) corners.push_back({flume.points[i], exact[i], 0.01});
    PoseChange off;
    off << 0.02, -0.03, 0.01, 10, -20, 30;
    const auto fit = fit_pose_to(flume.scene.calibration.camera, changed(flume.view.pose, off), corners, above);
    ASSERT_TRUE(fit);
    EXPECT_LT((fit->pose.centre() - flume.view.pose.centre()).norm(), 1e-6);
    EXPECT_LT(change_between(fit->pose, flume.view.pose).head<3>().norm(), 1e-9);
  }
}

TEST(PoseFit, ScattersAsItsCovarianceSaysDryAndThroughWater) {
  PosedFlume flume;
  constexpr int kDraws = 200;
  constexpr double kLevelDeviation = 0.2;
  for (const bool wet : {false, true}) {
    const WaterAbove believed = flume.still(80);
    double nees = 0, outside = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      // The gauge is wrong by its deviation.
      const WaterAbove true_water = flume.still(80 + flume.noise(kLevelDeviation).x());
      const auto corners = flume.noisy(flume.pixels(flume.view, wet ? &true_water : nullptr), 0.02);
      const auto fit = fit_pose_to(flume.scene.calibration.camera, flume.view.pose, corners, wet ? &believed : nullptr);
      ASSERT_TRUE(fit);
      const PoseChange off = change_between(flume.view.pose, fit->pose);
      const PoseMatrix covariance = fit->covariance(wet ? kLevelDeviation : 0);
      const PoseChange per = covariance.diagonal().cwiseSqrt().cwiseInverse(), scaled = per.cwiseProduct(off);
      nees += scaled.dot(PoseMatrix(per.asDiagonal() * covariance * per.asDiagonal()).ldlt().solve(scaled));
      outside += (scaled.cwiseAbs().maxCoeff() > 3) ? 1 : 0;
    }
    // Chi-square of 6 kDraws degrees of freedom, 99.9 %.
    EXPECT_NEAR(nees / (6 * kDraws), 1, 3.29 * std::sqrt(2.0 / (6 * kDraws))) << wet;
    // Of six normal numbers 1.6 % have one beyond three deviations: 3.2 of 200, 10 with a probability of 0.001.
    EXPECT_LE(outside, 10) << wet;
  }
}

TEST(PoseFit, TellsWhatItCannotDo) {
  PosedFlume flume;
  const auto& camera = flume.scene.calibration.camera;
  auto corners = flume.noisy(flume.pixels(flume.view, nullptr), 0.01);
  EXPECT_EQ(fit_pose_to(camera, flume.view.pose, std::span(corners).first(2), nullptr).error(), Errc::kInvalidArgument);
  corners[3].sigma = 0;
  EXPECT_EQ(fit_pose_to(camera, flume.view.pose, corners, nullptr).error(), Errc::kInvalidArgument);
  corners[3].sigma = 0.01;
  EXPECT_EQ(fit_pose_to(camera, flume.view.pose, std::span(corners).first(21), nullptr).error(), Errc::kSingular);
  Pose<double> behind = flume.view.pose;
  behind.translation.z() = -500;
  EXPECT_EQ(fit_pose_to(camera, behind, corners, nullptr).error(), Errc::kOutOfDomain);
}

TEST(HeightOfPose, SurfacesScatterByItWhenOnlyThePoseDoes) {
  PosedFlume flume;
  const auto modes = ModeList::standard(3).value();
  const WaterAbove still = flume.water(modes, fakes::coefficients({80, 0, 0}));
  const auto wet = flume.pixels(flume.view, &still), dry = flume.pixels(flume.view, nullptr);
  auto estimator = SurfaceEstimator<double>::make(still.model, still.media, flume.points, {}, 231).value();
  constexpr int kDraws = 150;
  double stated = 0, squares = 0;
  Coefficients<double> mode_squares = Coefficients<double>::Zero(3), mode_stated = mode_squares;
  for (int draw = 0; draw < kDraws; ++draw) {
    const auto corners = flume.noisy(dry, 0.05);
    const auto fit = fit_pose_to(flume.scene.calibration.camera, flume.view.pose, corners, nullptr);
    ASSERT_TRUE(fit);
    const View<double> view{flume.scene.calibration.camera, fit->pose};
    std::vector<Observation<double>> observed;
    std::vector<CountedCorner> counted;
    for (std::size_t i = 0; i < wet.size(); ++i) {
      observed.push_back({static_cast<int>(i), wet[i], view.camera.undistort(wet[i]).value(), 1});
      counted.push_back({0, static_cast<int>(i), 1});
    }
    const CameraObservations<double> camera{&view, observed};
    const std::vector<Coefficients<double>> starts = {still.surface};
    const auto estimate = estimator.estimate({&camera, 1}, starts);
    ASSERT_FALSE(failed(estimate.stop));
    const Coefficients<double> off = estimate.coefficients - still.surface;
    for (const auto& point : flume.points)
      squares += std::pow(still.model.height(off, point.x(), point.y()), 2) / static_cast<double>(flume.points.size());
    mode_squares += off.cwiseAbs2();
    const UnsurePose unsure{view, {.pose = fit->covariance()}};
    const auto systematic = surface_of_poses({&unsure, 1}, flume.points, still, counted);
    ASSERT_TRUE(systematic);
    stated += systematic->height_deviation * systematic->height_deviation;
    mode_stated += systematic->deviation.cwiseAbs2();
  }
  // Of 150 draws a deviation is known to 6 %; three of them.
  EXPECT_NEAR(std::sqrt(squares / stated), 1, 0.18);
  for (int j = 0; j < 3; ++j) EXPECT_NEAR(std::sqrt(mode_squares[j] / mode_stated[j]), 1, 0.18) << j;
}

// A calibration from which draws are taken: its errors lean on each other, as those of a calibration do.
IntrinsicsMatrix leaning_calibration() {
  // Deviations: fx, fy, cx, cy in px, k1, k2, p1, p2, k3.
  Eigen::Matrix<double, kMaxIntrinsics, 1> deviation = Eigen::Matrix<double, kMaxIntrinsics, 1>::Zero();
  deviation.head<9>() << 0.8, 0.8, 0.5, 0.5, 0.002, 0.01, 2e-4, 2e-4, 0.01;
  IntrinsicsMatrix correlation = IntrinsicsMatrix::Identity();
  const auto lean = [&](int a, int b, double by) { correlation(a, b) = correlation(b, a) = by; };
  lean(0, 1, 0.95);
  lean(4, 5, -0.9);
  lean(2, 7, 0.6);
  lean(3, 6, 0.6);
  return deviation.asDiagonal() * correlation * deviation.asDiagonal();
}

// What a calibration and a pose that were found with errors leave in the surface, over draws of both: the calibration is
// wrong, the pose is fitted with it to noisy corners of the true camera, then the true camera's corners of the water are fitted.
void expect_scatter_as_stated(const WaterAbove& water, const char* name) {
  PosedFlume flume;
  const int n = water.model.modes.size();
  const IntrinsicsMatrix covariance = leaning_calibration();
  IntrinsicsMatrix root = IntrinsicsMatrix::Zero();
  root.topLeftCorner<9, 9>() = covariance.topLeftCorner<9, 9>().llt().matrixL();
  const auto wet = flume.pixels(flume.view, &water), dry = flume.pixels(flume.view, nullptr);
  auto estimator = SurfaceEstimator<double>::make(water.model, water.media, flume.points, {}, 231).value();
  const Vec2<double> centre(100, 200);
  constexpr int kDraws = 300;
  double stated = 0, scattered = 0;
  Coefficients<double> mode_squares = Coefficients<double>::Zero(n), mode_stated = mode_squares;
  for (int draw = 0; draw < kDraws; ++draw) {
    auto numbers = intrinsics_of(flume.view.camera);
    Eigen::Map<Eigen::Matrix<double, kMaxIntrinsics, 1>> wrong(numbers.data());
    Eigen::Matrix<double, kMaxIntrinsics, 1> unit;
    for (double& x : unit) x = flume.noise(1).x();
    wrong += root * unit;
    const auto camera =
        CameraModel<double>::make(numbers[0], numbers[1], numbers[2], numbers[3], std::span(numbers).subspan(kPinhole, 5))
            .value();
    const auto fit = fit_pose_to(camera, flume.view.pose, flume.noisy(dry, 0.05), nullptr);
    ASSERT_TRUE(fit);
    const View<double> view{camera, fit->pose};
    std::vector<Observation<double>> observed;
    std::vector<CountedCorner> counted;
    for (std::size_t i = 0; i < wet.size(); ++i) {
      observed.push_back({static_cast<int>(i), wet[i], view.camera.undistort(wet[i]).value(), 1});
      counted.push_back({0, static_cast<int>(i), 1});
    }
    const CameraObservations<double> camera_observations{&view, observed};
    const std::vector<Coefficients<double>> starts = {water.surface};
    const auto estimate = estimator.estimate({&camera_observations, 1}, starts);
    ASSERT_FALSE(failed(estimate.stop));
    const Coefficients<double> off = estimate.coefficients - water.surface;
    scattered += std::pow(water.model.height(off, centre.x(), centre.y()), 2);
    mode_squares += off.cwiseAbs2();
    // The pose's corners have no error beyond the stated one: its cofactor is its covariance.
    const UnsurePose unsure{view, {fit->cofactor, covariance, fit->by_intrinsics}};
    const WaterAbove found{water.model, estimate.coefficients, water.media};
    const auto systematic = surface_of_poses({&unsure, 1}, flume.points, found, counted);
    ASSERT_TRUE(systematic);
    stated += std::pow(systematic->deviation_at(water.model, centre), 2);
    mode_stated += systematic->deviation.cwiseAbs2();
    // Not the pose's alone: half of it would be missing.
    const UnsurePose pose_alone{view, {.pose = fit->cofactor}};
    EXPECT_LT(surface_of_poses({&pose_alone, 1}, flume.points, found, counted)->deviation_at(water.model, centre),
              0.8 * systematic->deviation_at(water.model, centre));
  }
  // Of 300 draws a deviation is known to 4 %; 20 % is asked for.
  EXPECT_NEAR(std::sqrt(scattered / stated), 1, 0.13) << name << ": " << std::sqrt(stated / kDraws) << " mm";
  for (int j = 0; j < n; ++j) EXPECT_NEAR(std::sqrt(mode_squares[j] / mode_stated[j]), 1, 0.13) << name << ", mode " << j;
}

TEST(HeightOfPose, SurfacesScatterByItWhenCalibrationAndPoseDoOnStillWater) {
  const PosedFlume flume;
  expect_scatter_as_stated(flume.water(ModeList::standard(3).value(), fakes::coefficients({80, 0, 0})), "still");
}

TEST(HeightOfPose, SurfacesScatterByItWhenCalibrationAndPoseDoUnderWaves) {
  const PosedFlume flume;
  expect_scatter_as_stated(flume.water(ModeList::standard(5).value(), fakes::coefficients({80, 0.5, -0.5, 3, 3})), "waves");
}

TEST(SystematicWatch, ComesToWhatOneFitGivesAndFollowsTheLevel) {
  const PosedFlume flume;
  const auto fit = fit_pose_to(flume.scene.calibration.camera, flume.view.pose,
                               PosedFlume().noisy(flume.pixels(flume.view, nullptr), 0.05), nullptr);
  ASSERT_TRUE(fit);
  const UnsurePose unsure{flume.view, {fit->cofactor, leaning_calibration(), fit->by_intrinsics}};
  const auto modes = ModeList::standard(3).value();
  const auto whole = [&](double level) {
    std::vector<CountedCorner> counted;
    for (int i = 0; i < 231; ++i) counted.push_back({0, i, 1});
    const WaterAbove water = flume.water(modes, fakes::coefficients({level, 0, 0}));
    return surface_of_poses({&unsure, 1}, flume.points, water, counted)->deviation[0];
  };
  SystematicWatch watch(unsure, flume.scene.width(), flume.scene.height(), flume.points,
                        flume.water(modes, fakes::coefficients({80, 0, 0})), {100, 200});
  ASSERT_EQ(watch.deviation().size(), 3);
  EXPECT_NEAR(watch.deviation()[0], whole(80), 1e-9);
  ASSERT_GT(std::abs(whole(120) - whole(80)), 1e-3);
  std::vector<Observation<float>> corners(231);
  for (int i = 0; i < 231; ++i) corners[static_cast<std::size_t>(i)].point = i;
  Coefficients<float> risen(3);
  risen << 120, 0, 0;
  const double before = whole(80);
  const fakes::AllocationGauge heap;
  // One way through the corners of a fit, then the next frame's start.
  const int frames = (231 + SystematicWatch::kCornersAFrame - 1) / SystematicWatch::kCornersAFrame;
  for (int frame = 0; frame < frames; ++frame) {
    watch.follow(risen, corners);
    EXPECT_NEAR(watch.deviation()[0], before, 1e-9) << frame;
  }
  watch.follow(risen, corners);
  EXPECT_EQ(heap.count(), 0);
  EXPECT_NEAR(watch.deviation()[0], whole(120), 1e-6);
  EXPECT_GT(watch.height_deviation(), 0);
}

TEST(PoseComparison, FDistributionHasItsClosedForms) {
  // Two degrees above: (1 + 2 f / d)^(-d/2). One and one: 1 - 2/pi atan(sqrt f).
  EXPECT_NEAR(f_survival(3, 2, 10) / std::pow(1.6, -5), 1, 1e-12);
  EXPECT_NEAR(f_survival(40, 2, 400) / std::pow(1.2, -200), 1, 1e-9);
  EXPECT_NEAR(f_survival(1, 1, 1), 0.5, 1e-12);
  EXPECT_NEAR(f_survival(3, 1, 1), 1 - 2 / fakes::kPi * std::atan(std::sqrt(3)), 1e-12);
  EXPECT_EQ(f_survival(0, 6, 100), 1);
}

TEST(PoseComparison, ToldByChanceAsOftenAsItSays) {
  PosedFlume flume;
  std::vector<PoseCorner> workspace(flume.points.size());
  int below_a_tenth = 0, told = 0;
  constexpr int kDraws = 1000;
  for (int draw = 0; draw < kDraws; ++draw) {
    const auto pairs = flume.pairs(flume.view, 0.006);
    const auto found = compare_poses(flume.scene.calibration.camera, flume.view.pose, pairs, {}, {}, workspace);
    ASSERT_TRUE(found);
    below_a_tenth += found->by_chance < 0.1 ? 1 : 0;
    told += found->by_chance < 1e-6 ? 1 : 0;
  }
  EXPECT_NEAR(below_a_tenth, 100, 3.29 * std::sqrt(90.0));
  EXPECT_EQ(told, 0);
}

TEST(PoseComparison, SmallTurnsAndShiftsAreToldAndMeasured) {
  PosedFlume flume;
  std::vector<PoseCorner> workspace(flume.points.size());
  constexpr int kDraws = 30;
  double nees = 0;
  for (int axis = 0; axis < 6; ++axis) {
    View<double> later = flume.view;
    const PoseChange change = unit_change(axis, axis < 3 ? 0.02 * fakes::kPi / 180 : 0.1);
    later.pose = changed(flume.view.pose, change);
    for (int draw = 0; draw < kDraws; ++draw) {
      const auto pairs = flume.pairs(later, 0.013);  // noise 4
      const auto found = compare_poses(flume.scene.calibration.camera, flume.view.pose, pairs, {}, {}, workspace);
      ASSERT_TRUE(found);
      EXPECT_LT(found->by_chance, 1e-6) << axis;
      EXPECT_GT(found->largest_move_px, 0.02) << axis;
      const PoseChange per = found->covariance.diagonal().cwiseSqrt().cwiseInverse();
      const PoseChange off = per.cwiseProduct(found->change - change);
      nees += off.dot(PoseMatrix(per.asDiagonal() * found->covariance * per.asDiagonal()).ldlt().solve(off));
    }
  }
  // Chi-square of 36 kDraws degrees of freedom, 99.9 %.
  EXPECT_NEAR(nees / (36 * kDraws), 1, 3.29 * std::sqrt(2.0 / (36 * kDraws)));
}

TEST(PoseComparison, WhatBothImagesShareIsNoMove) {
  PosedFlume flume;
  std::vector<PoseCorner> workspace(flume.points.size());
  std::vector<CornerPair> pairs = flume.pairs(flume.view, 0.006);
  // A print that is off by a third of a pixel, fifty times the noise, in both images.
  for (CornerPair& pair : pairs) {
    const Vec2<double> print = flume.noise(0.3);
    pair.before += print;
    pair.after += print;
  }
  const auto found = compare_poses(flume.scene.calibration.camera, flume.view.pose, pairs, {}, {}, workspace);
  ASSERT_TRUE(found);
  EXPECT_GT(found->by_chance, 1e-3);
  EXPECT_NEAR(found->variance_factor, 1, 0.3);
}

TEST(PoseComparison, ThroughWaterALevelThatIsNotSureIsNoMove) {
  PosedFlume flume;
  std::vector<PoseCorner> workspace(flume.points.size());
  const WaterAbove believed = flume.still(80), risen = flume.still(80.5);
  const auto dry = flume.pixels(flume.view, nullptr), wet = flume.pixels(flume.view, &risen);
  std::vector<CornerPair> pairs;
  for (std::size_t i = 0; i < dry.size(); ++i)
    pairs.push_back({flume.points[i], dry[i] + flume.noise(0.006), wet[i] + flume.noise(0.006), 0.006, 0.006});
  const auto& camera = flume.scene.calibration.camera;
  const auto sure = compare_poses(camera, flume.view.pose, pairs, {}, {&believed, 0.01}, workspace);
  const auto unsure = compare_poses(camera, flume.view.pose, pairs, {}, {&believed, 0.4}, workspace);
  ASSERT_TRUE(sure && unsure);
  EXPECT_LT(sure->by_chance, 1e-6);
  EXPECT_GT(unsure->by_chance, 1e-2);
}

// A rig that was measured dry, with errors as its covariance says, and is looked at again.
PoseCheckRequest stated_by(PosedFlume& flume, const View<double>& then) {
  const auto fit =
      fit_pose_to(flume.scene.calibration.camera, then.pose, flume.noisy(flume.pixels(then, nullptr), 0.01), nullptr);
  PoseCheckRequest request;
  request.camera = flume.scene.calibration.camera;
  request.stated = fit->pose;
  request.stated_covariance = fit->cofactor;
  request.media = flume.scene.media;
  request.highest_mm = 250;
  return request;
}

TEST(PoseCheck, AnUnmovedRigIsToldByChanceAsOftenAsItSaysDryAndThroughWaterThatNobodyMeasured) {
  PosedFlume flume;
  flume.thin_out();
  for (const bool wet : {false, true}) {
    constexpr int kDraws = 50;
    int below_a_tenth = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const PoseCheckRequest request = stated_by(flume, flume.view);
      const WaterAbove still = flume.still(60 + draw);
      const auto check = check_pose(request, flume.noisy(flume.pixels(flume.view, wet ? &still : nullptr), 0.01));
      ASSERT_TRUE(check) << to_string(check.error());
      EXPECT_EQ(check->wet, wet);
      EXPECT_GT(check->by_chance, 1e-5);
      below_a_tenth += check->by_chance < 0.1 ? 1 : 0;
      if (wet) {
        EXPECT_NEAR(check->level_mm, 60 + draw, 4.5 * check->level_deviation_mm);
      }
    }
    EXPECT_NEAR(below_a_tenth, 5, 3.29 * std::sqrt(4.5)) << wet;
  }
}

TEST(PoseCheck, SmallTurnsAreToldDryAndThroughWaterThatNobodyMeasured) {
  PosedFlume flume;
  const WaterAbove still = flume.still(95);
  const WaterAbove* media[] = {nullptr, &still};
  for (const WaterAbove* above : media)
    for (int axis = 0; axis < 3; ++axis) {
      const PoseCheckRequest request = stated_by(flume, flume.view);
      View<double> later = flume.view;
      later.pose = changed(flume.view.pose, unit_change(axis, 0.02 * fakes::kPi / 180));
      const auto check = check_pose(request, flume.noisy(flume.pixels(later, above), 0.01));
      ASSERT_TRUE(check) << to_string(check.error());
      EXPECT_LT(check->by_chance, 1e-6) << axis;
      EXPECT_GT(check->largest_move_px, 0.02) << axis;
    }
}

TEST(PoseCheck, PlatesLieOnThePatternWithAndWithoutWater) {
  PosedFlume flume;
  flume.scene.media.layers[0] = {12, 1.49};
  flume.scene.media.n_layers = 1;
  Media<double> air = flume.scene.media;
  air.water = air.air;
  WaterAbove dry = flume.still(13);
  dry.media = air;
  const WaterAbove still = flume.still(90);
  const WaterAbove* media[] = {&dry, &still};
  for (const WaterAbove* above : media) {
    const auto check = check_pose(stated_by(flume, flume.view), flume.noisy(flume.pixels(flume.view, above), 0.01));
    ASSERT_TRUE(check) << to_string(check.error());
    EXPECT_EQ(check->wet, above == &still);
    EXPECT_GT(check->by_chance, 1e-5);
  }
}

}  // namespace
}  // namespace srd::dsp
