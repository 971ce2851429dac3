// SPDX-License-Identifier: Apache-2.0
#include "dsp/pipeline/surface_tracker.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "drivers/camera/simulator/renderer.hpp"
#include "tests/fakes/allocation_gauge.hpp"

namespace srd::dsp {
namespace {

constexpr std::int64_t kFramePeriod = 20'000'000;  // ns

struct PoseError {
  Vec3<double> beside = {0, 0, 0};  // mm, W
  Vec3<double> turn = {0, 0, 0};    // rad, about the camera's own axes
};

// A rendered flume and a tracker that looks at it with exact calibration and pose.
class Flume {
 public:
  explicit Flume(Scene scene = default_scene()) : scene_(std::move(scene)), renderer_(Renderer::make(scene_).value()) {
    pixels_.resize(static_cast<std::size_t>(scene_.width() * scene_.height()));
  }

  SurfaceTracker<double> tracker(double guess = 80, FirstSquare first = FirstSquare::kDark,
                                 const SurfaceTrackerOptions& options = {}, const PoseError& error = {}) {
    CameraSetup<double> setup{believed_view(error), scene_.width(), scene_.height(), {}};
    Coefficients<double> start = Coefficients<double>::Zero(scene_.surface.modes.size());
    start[0] = guess;
    const auto points = scene_.points();
    return SurfaceTracker<double>::make(std::span(&setup, 1), Pattern::make(points, first).value(), scene_.surface,
                                        scene_.media, start, EstimatorOptions{}, options)
        .value();
  }

  View<double> believed_view(const PoseError& error) const {
    View<double> view = scene_.view();
    view.pose.translation += view.pose.rotation * error.beside;
    const double angle = error.turn.norm();
    if (angle > 0) {
      const Mat3<double> turn = Eigen::AngleAxis<double>(angle, error.turn / angle).toRotationMatrix();
      view.pose = {turn * view.pose.rotation, turn * view.pose.translation};
    }
    return view;
  }

  GrayView frame(std::uint64_t number) {
    renderer_.render(number, {pixels_.data(), scene_.width(), scene_.height(), scene_.width()});
    return view();
  }
  // Even rows of one frame, odd rows of another.
  GrayView interlaced(std::uint64_t even, std::uint64_t odd) {
    frame(odd);
    const std::vector<std::uint8_t> other = pixels_;
    frame(even);
    for (int v = 1; v < scene_.height(); v += 2)
      std::copy_n(other.begin() + v * scene_.width(), scene_.width(), pixels_.begin() + v * scene_.width());
    return view();
  }
  // Columns from u on, shifted by a pixel to the right.
  void tear(int u) {
    for (int v = 0; v < scene_.height(); ++v) {
      const auto row = pixels_.begin() + v * scene_.width();
      std::copy_backward(row + u, row + scene_.width() - 1, row + scene_.width());
    }
  }
  GrayView view() const { return {pixels_.data(), scene_.width(), scene_.height(), scene_.width()}; }
  // Covers a rectangle with grey.
  void cover(int u0, int v0, int u1, int v1, std::uint8_t level) {
    for (int v = std::max(v0, 0); v < std::min(v1, scene_.height()); ++v)
      for (int u = std::max(u0, 0); u < std::min(u1, scene_.width()); ++u)
        pixels_[static_cast<std::size_t>(v * scene_.width() + u)] = level;
  }
  // Covers all but a square of half this side.
  void leave_open(int u, int v, int half) {
    cover(0, 0, scene_.width(), v - half, 128);
    cover(0, v + half, scene_.width(), scene_.height(), 128);
    cover(0, 0, u - half, scene_.height(), 128);
    cover(u + half, 0, scene_.width(), scene_.height(), 128);
  }
  double error2(std::uint64_t number, const Coefficients<double>& a) const {
    const Coefficients<double> truth = scene_.coefficients(number);
    double sum = 0;
    const auto points = scene_.points();
    for (const auto& p : points) {
      const double e = scene_.surface.height(a, p.x(), p.y()) - scene_.surface.height(truth, p.x(), p.y());
      sum += e * e;
    }
    return sum / static_cast<double>(points.size());
  }
  // Corners whose identity or place is wrong by more than a pixel.
  int wrong(std::uint64_t number, const FrameResult<double>& result) const {
    const auto truth = truth_pixels(scene_, number).value();
    int n = 0;
    for (const auto& o : result.observations[0])
      if ((o.pixel - truth[static_cast<std::size_t>(o.point)]).norm() > 1) ++n;
    return n;
  }
  const Scene& scene() const { return scene_; }

 private:
  Scene scene_;
  Renderer renderer_;
  std::vector<std::uint8_t> pixels_;
};

const FrameResult<double>& step(SurfaceTracker<double>& tracker, GrayView image, std::uint64_t number) {
  return tracker.process(std::span(&image, 1), static_cast<std::int64_t>(number) * kFramePeriod);
}

TEST(SurfaceTracker, FollowsTheFlumeWithinHundredthsOfAMillimetre) {
  Flume flume;
  auto tracker = flume.tracker();
  double sum = 0;
  for (std::uint64_t k = 0; k < 20; ++k) {
    const auto& result = step(tracker, flume.frame(k), k);
    ASSERT_EQ(result.status, TrackStatus::kOk) << k;
    EXPECT_EQ(result.acquired, k == 0);
    EXPECT_EQ(flume.wrong(k, result), 0);
    EXPECT_EQ(result.estimate.corners_used, 231);
    sum += flume.error2(k, result.estimate.coefficients);
  }
  EXPECT_LT(std::sqrt(sum / 20), 0.02);
}

TEST(SurfaceTracker, TellsInterlacedPicturesFromTheirFirstOne) {
  Flume flume;
  auto tracker = flume.tracker();
  for (std::uint64_t k = 0; k < 6; ++k) {
    const auto& result = step(tracker, flume.interlaced(k, k + 1), k);
    EXPECT_EQ(result.status, TrackStatus::kInterlaced) << k;
    EXPECT_TRUE(result.has_estimate());
    EXPECT_FALSE(result.has_surface());
    EXPECT_EQ(result.acquired, k == 0);
  }
}

TEST(SurfaceTracker, TakesNoProgressivePictureForAnInterlacedOne) {
  for (const double noise : {0.0, 4.0}) {
    Scene scene = default_scene();
    scene.noise = noise;
    for (ModeMotion& motion : scene.motions) motion.frequency_hz *= 8;
    Flume flume(scene);
    auto tracker = flume.tracker();
    for (std::uint64_t k = 0; k < 10; ++k) EXPECT_EQ(step(tracker, flume.frame(k), k).status, TrackStatus::kOk) << k;
  }
}

TEST(SurfaceTracker, TellsAFrameWhoseCornersContradictEachOther) {
  Flume flume;
  auto tracker = flume.tracker();
  for (std::uint64_t k = 0; k < 8; ++k) {
    flume.frame(k);
    const bool torn = k == 5 || k == 6;
    if (torn) flume.tear(640);
    const auto& result = step(tracker, flume.view(), k);
    EXPECT_EQ(result.status, torn ? TrackStatus::kInconsistent : TrackStatus::kOk) << k;
    EXPECT_TRUE(result.has_estimate());
  }
}

// A print's own faults, or a pose's, are in every frame: they are not what a frame contradicts.
TEST(SurfaceTracker, WhatEveryFrameLeavesIsNoContradiction) {
  Flume flume;
  auto tracker = flume.tracker(80, FirstSquare::kDark, {}, {{0.4, -0.3, 0.5}});
  for (std::uint64_t k = 0; k < 6; ++k) {
    const auto& result = step(tracker, flume.frame(k), k);
    EXPECT_EQ(result.status, TrackStatus::kOk) << k;
    EXPECT_GT(result.estimate.variance_factor, 2) << k;
  }
}

// The tracker's fit starts near its end and stops early. With a pose that puts every corner a pixel off, its residuals are
// up to sixty times their noise, and no trend is right; it must end where a patient fit from far off ends.
class SurfaceTrackerOff : public testing::TestWithParam<PoseError> {};

TEST_P(SurfaceTrackerOff, FindsTheBestSurfaceAndTellsThatItFitsBadly) {
  const PoseError error = GetParam();
  Flume flume;
  auto tracker = flume.tracker(80, FirstSquare::kDark, {}, error);
  const View<double> view = flume.believed_view(error);
  EstimatorOptions patient;
  patient.epsg = 1e-9;
  patient.max_iterations = 200;
  const auto points = flume.scene().points();
  auto estimator = SurfaceEstimator<double>::make(flume.scene().surface, flume.scene().media, points, patient, 1000).value();
  Coefficients<double> far = Coefficients<double>::Zero(flume.scene().surface.modes.size());
  far[0] = 75;
  for (std::uint64_t k = 0; k < 8; ++k) {
    const auto& result = step(tracker, flume.frame(k), k);
    ASSERT_EQ(result.status, TrackStatus::kOk) << k;
    EXPECT_EQ(result.acquired, k == 0);
    EXPECT_EQ(flume.wrong(k, result), 0);
    std::vector<Observation<double>> corners(result.observations[0].begin(), result.observations[0].end());
    for (auto& corner : corners) corner.foot = Observation<double>().foot;
    const CameraObservations<double> seen{&view, corners};
    const auto best = estimator.estimate(std::span(&seen, 1), std::span(&far, 1));
    ASSERT_FALSE(failed(best.stop)) << to_string(best.stop);
    double square = 0;
    for (const auto& p : points) {
      const double apart = flume.scene().surface.height(result.estimate.coefficients, p.x(), p.y()) -
                           flume.scene().surface.height(best.coefficients, p.x(), p.y());
      square += apart * apart / static_cast<double>(points.size());
    }
    EXPECT_LT(std::sqrt(square), 0.05 * best.height_deviation) << k;
    EXPECT_NEAR(result.estimate.height_deviation, best.height_deviation, 0.01 * best.height_deviation) << k;
    // 1 is usual. Most of the fault goes into the surface, which no corner can tell.
    EXPECT_GT(result.estimate.variance_factor, 30) << k;
    EXPECT_NEAR(result.estimate.cost, best.cost, 1e-4 * best.cost) << k;
  }
}

constexpr double kPixelTurn = 1.0 / 2150;  // rad: a pixel in the middle of the image

INSTANTIATE_TEST_SUITE_P(Pose, SurfaceTrackerOff,
                         testing::Values(PoseError{{0.45, 0, 0}, {0, 0, 0}},  // mm: a pixel at 0.95 m
                                         PoseError{{0, 0, 0}, {kPixelTurn, 0, 0}}, PoseError{{0, 0, 0}, {0, kPixelTurn, 0}},
                                         PoseError{{0, 0, 0}, {0, 0, 1.0 / 300}}));  // a pixel 300 px off the middle

TEST(SurfaceTracker, StatedDeviationsCoverTheError) {
  Flume flume;
  auto tracker = flume.tracker();
  double normalised = 0;
  int n = 0;
  for (std::uint64_t k = 0; k < 20; ++k) {
    const auto& result = step(tracker, flume.frame(k), k);
    ASSERT_TRUE(result.has_surface());
    const Coefficients<double> e = result.estimate.coefficients - flume.scene().coefficients(k);
    normalised += e.dot(result.estimate.information * e);
    n += static_cast<int>(e.size());
  }
  // Chi square of 100 degrees of freedom over 100: within [0.6, 1.5] with 99.9 %; the corners' own bias adds a little.
  EXPECT_GT(normalised / n, 0.5);
  EXPECT_LT(normalised / n, 2.0);
}

TEST(SurfaceTracker, KeepsIdentitiesThroughGlare) {
  Scene scene = default_scene();
  scene.glare = {{300, 200, 900, 100, 25, 255}, {700, 400, -700, 300, 40, 255}, {1000, 300, 0, 0, 15, 255}};
  Flume flume(scene);
  auto tracker = flume.tracker();
  int missing = 0;
  for (std::uint64_t k = 0; k < 15; ++k) {
    const auto& result = step(tracker, flume.frame(k), k);
    ASSERT_EQ(result.status, TrackStatus::kOk) << k;
    EXPECT_EQ(flume.wrong(k, result), 0) << k;
    EXPECT_LT(std::sqrt(flume.error2(k, result.estimate.coefficients)), 0.05);
    missing += 231 - result.estimate.corners_used;
  }
  EXPECT_GT(missing, 0);  // the glare was there
}

TEST(SurfaceTracker, HiddenCornersCostOnlyThemselves) {
  Flume flume;
  auto tracker = flume.tracker();
  for (std::uint64_t k = 0; k < 8; ++k) {
    flume.frame(k);
    if (k >= 3) flume.cover(500, 0, 750, 640, 60);
    const auto& result = step(tracker, flume.view(), k);
    ASSERT_EQ(result.status, TrackStatus::kOk);
    EXPECT_EQ(flume.wrong(k, result), 0);
    if (k >= 3) {
      EXPECT_LT(result.estimate.corners_used, 190);
    }
    EXPECT_LT(std::sqrt(flume.error2(k, result.estimate.coefficients)), 0.05);
  }
}

TEST(SurfaceTracker, LosesThePatternInTheDarkAndFindsItAgain) {
  Flume flume;
  auto tracker = flume.tracker();
  for (std::uint64_t k = 0; k < 14; ++k) {
    flume.frame(k);
    const bool dark = k >= 4 && k < 9;
    if (dark) flume.cover(0, 0, 1280, 640, 12);
    const auto& result = step(tracker, flume.view(), k);
    EXPECT_EQ(result.has_surface(), !dark) << k;
    EXPECT_EQ(result.state, dark ? TrackState::kLost : TrackState::kTracking);
    EXPECT_EQ(result.acquired, k == 0 || k == 9);
    EXPECT_EQ(flume.wrong(k, result), 0);
  }
}

TEST(SurfaceTracker, FollowsThroughDroppedFrames) {
  Flume flume;
  auto tracker = flume.tracker();
  int acquired = 0;
  for (const std::uint64_t k : {0, 1, 2, 5, 6, 9, 10, 13, 14}) {
    const auto& result = step(tracker, flume.frame(k), k);
    ASSERT_EQ(result.status, TrackStatus::kOk) << k;
    acquired += result.acquired ? 1 : 0;
    EXPECT_EQ(flume.wrong(k, result), 0);
  }
  EXPECT_EQ(acquired, 1);
}

TEST(SurfaceTracker, FindsThePatternFromAGuessFarOff) {
  for (const double guess : {50.0, 70.0, 95.0, 120.0}) {
    Flume flume;
    auto tracker = flume.tracker(guess);
    const auto& result = step(tracker, flume.frame(0), 0);
    ASSERT_EQ(result.status, TrackStatus::kOk) << guess;
    EXPECT_EQ(flume.wrong(0, result), 0);
    EXPECT_LT(std::sqrt(flume.error2(0, result.estimate.coefficients)), 0.05);
  }
}

TEST(SurfaceTracker, LearnsThePolarityWhenItIsNotTold) {
  Flume flume;
  auto tracker = flume.tracker(80, FirstSquare::kUnknown);
  EXPECT_EQ(step(tracker, flume.frame(0), 0).status, TrackStatus::kOk);
}

TEST(SurfaceTracker, TheOtherPolarityGivesNoSurface) {
  Flume flume;
  auto tracker = flume.tracker(80, FirstSquare::kBright);
  const auto& result = step(tracker, flume.frame(0), 0);
  EXPECT_FALSE(result.has_surface());
}

// Only a handful of corners in view, as through a window in a mask.
TEST(SurfaceTracker, PlacesASmallPatchByTheLevelGuess) {
  Flume flume;
  SurfaceTrackerOptions options;
  options.min_corners = 5;
  auto tracker = flume.tracker(78, FirstSquare::kDark, options);
  const auto truth = truth_pixels(flume.scene(), 0).value();
  const Vec2<double> centre = truth[static_cast<std::size_t>(5 * 21 + 10)];
  flume.frame(0);
  const int u = static_cast<int>(centre.x()), v = static_cast<int>(centre.y());
  flume.leave_open(u, v, 80);
  const auto& result = step(tracker, flume.view(), 0);
  ASSERT_EQ(result.status, TrackStatus::kOk);
  EXPECT_LE(result.found, 25);
  EXPECT_EQ(flume.wrong(0, result), 0);
}

// A few corners in one place fit their pixels well and say next to nothing of the level.
TEST(SurfaceTracker, GivesNoSurfaceThatItsCornersDoNotDetermine) {
  Flume flume;
  SurfaceTrackerOptions limited, unlimited;
  limited.max_deviation_mm = 0.1;
  unlimited.max_deviation_mm = 0;
  auto careful = flume.tracker(78, FirstSquare::kDark, limited), careless = flume.tracker(78, FirstSquare::kDark, unlimited);
  const auto truth = truth_pixels(flume.scene(), 0).value();
  const Vec2<double> centre = truth[static_cast<std::size_t>(5 * 21 + 10)];
  flume.frame(0);
  flume.leave_open(static_cast<int>(centre.x()), static_cast<int>(centre.y()), 56);
  const auto& given = step(careless, flume.view(), 0);
  ASSERT_EQ(given.status, TrackStatus::kOk);
  EXPECT_GE(given.found, 5);
  EXPECT_GT(given.estimate.height_deviation, 0.1);
  EXPECT_LT(given.estimate.reprojection_rms, 0.1);
  EXPECT_EQ(step(careful, flume.view(), 0).status, TrackStatus::kTooFewCorners);
  // The whole pattern is found as if nothing had been.
  const auto& next = step(careful, flume.frame(1), 1);
  EXPECT_EQ(next.status, TrackStatus::kOk);
  EXPECT_LT(next.estimate.height_deviation, 0.05);
}

// A patch that lies half-way between two placements must not be guessed.
TEST(SurfaceTracker, SaysWhenTwoPlacementsFitAlike) {
  Flume flume;
  SurfaceTrackerOptions options;
  options.min_corners = 5;
  auto tracker = flume.tracker(80, FirstSquare::kDark, options, {{10, 10, 0}});
  const auto truth = truth_pixels(flume.scene(), 0).value();
  const Vec2<double> centre = truth[static_cast<std::size_t>(5 * 21 + 10)];
  flume.frame(0);
  const int u = static_cast<int>(centre.x()), v = static_cast<int>(centre.y());
  flume.leave_open(u, v, 80);
  EXPECT_EQ(step(tracker, flume.view(), 0).status, TrackStatus::kAmbiguous);
}

TEST(SurfaceTracker, TwoCamerasMeasureOneSurface) {
  Scene left = default_scene(), right = default_scene();
  right.pose = look_at({420, 150, 900}, {110, 200, 0}, 3.1).value();
  right.seed = 2;
  Flume a(left), b(right);
  const std::array<CameraSetup<double>, 2> setups{CameraSetup<double>{left.view(), left.width(), left.height(), {}},
                                                  CameraSetup<double>{right.view(), right.width(), right.height(), {}}};
  Coefficients<double> guess = Coefficients<double>::Zero(5);
  guess[0] = 80;
  const auto points = left.points();
  auto tracker = SurfaceTracker<double>::make(setups, Pattern::make(points, FirstSquare::kDark).value(), left.surface,
                                              left.media, guess, EstimatorOptions{}, SurfaceTrackerOptions{})
                     .value();
  for (std::uint64_t k = 0; k < 4; ++k) {
    const std::array<GrayView, 2> images{a.frame(k), b.frame(k)};
    const auto& result = tracker.process(images, static_cast<std::int64_t>(k) * kFramePeriod);
    ASSERT_EQ(result.status, TrackStatus::kOk);
    EXPECT_GT(result.estimate.corners_used, 400);
    EXPECT_LT(std::sqrt(a.error2(k, result.estimate.coefficients)), 0.02);
  }
}

TEST(SurfaceTracker, RefusesImagesOfAnotherSize) {
  Flume flume;
  auto tracker = flume.tracker();
  GrayView image = flume.frame(0);
  image.height = 600;
  EXPECT_EQ(step(tracker, image, 0).status, TrackStatus::kBadImage);
  EXPECT_EQ(tracker.process({}, 0).status, TrackStatus::kBadImage);
}

TEST(SurfaceTracker, TakesNothingFromTheHeap) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  Flume flume;
  auto tracker = flume.tracker();
  const std::vector<std::uint8_t> black(1280 * 640, 5);
  std::array<std::vector<std::uint8_t>, 6> frames;
  for (std::uint64_t k = 0; k < frames.size(); ++k) {
    const GrayView v = flume.frame(k);
    frames[static_cast<std::size_t>(k)].assign(v.pixels, v.pixels + 1280 * 640);
  }
  std::int64_t allocations = 0;
  int surfaces = 0;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    // Back and forth, with a dark frame now and then: tracking, losing and finding are all in it.
    const std::uint64_t at = k % 10 < 6 ? k % 10 : 10 - k % 10;
    const GrayView image{k % 97 == 96 ? black.data() : frames[static_cast<std::size_t>(at)].data(), 1280, 640, 1280};
    const fakes::AllocationGauge gauge;
    surfaces += step(tracker, image, k).has_surface() ? 1 : 0;
    allocations += gauge.count();
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(surfaces, 950);
  const fakes::AllocationGauge gauge;
  const std::vector<int> taken(static_cast<std::size_t>(surfaces));
  EXPECT_GT(gauge.count(), 0) << "the gauge does not count";
}

}  // namespace
}  // namespace srd::dsp
