// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/pattern_metric/pattern_estimator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "drivers/camera/simulator/renderer.hpp"
#include "dsp/pipeline/surface_tracker.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

// The flume at a third of its resolution: squares of some 15 px, a region of 3 x 4 squares and more round the pattern's
// middle, well inside the printed squares.
Scene small_scene() {
  Scene scene = default_scene();
  const CameraModel<double>& camera = scene.calibration.camera;
  const double third = 1.0 / 3;
  scene.calibration.camera = CameraModel<double>::make(third * camera.fx(), third * camera.fy(), third * camera.cx(),
                                                       third * camera.cy(), camera.distortion())
                                 .value();
  scene.calibration.image_width /= 3;
  scene.calibration.image_height /= 3;
  return scene;
}

class Flume {
 public:
  explicit Flume(const Scene& scene = small_scene()) : scene_(scene), renderer_(Renderer::make(scene).value()) {
    pixels_.resize(static_cast<std::size_t>(scene_.width() * scene_.height()));
    // The box in the image of the inner corners within a square of the pattern's edge, over all frames.
    const auto seen = truth_pixels(scene_, 0).value();
    const int rows = scene_.pattern.rows, columns = scene_.pattern.columns;
    const auto at = [&](int row, int column) { return seen[static_cast<std::size_t>(row * columns + column)]; };
    std::array<double, 4> u{}, v{};
    const std::array<Vec2<double>, 4> outer{at(0, 0), at(0, columns - 1), at(rows - 1, 0), at(rows - 1, columns - 1)};
    for (std::size_t i = 0; i < outer.size(); ++i) {
      u[i] = outer[i].x();
      v[i] = outer[i].y();
    }
    std::sort(u.begin(), u.end());
    std::sort(v.begin(), v.end());
    region_ = {static_cast<int>(u[1]) + 8, static_cast<int>(v[1]) + 8, static_cast<int>(u[2]) - 8, static_cast<int>(v[2]) - 8};
  }

  GrayView frame(std::uint64_t number) {
    renderer_.render(number, {pixels_.data(), scene_.width(), scene_.height(), scene_.width()});
    return {pixels_.data(), scene_.width(), scene_.height(), scene_.width()};
  }
  [[nodiscard]] PatternSurface surface() const { return {SurfaceForm::kModes, scene_.surface}; }
  [[nodiscard]] CheckerPlane plane() const { return {scene_.pattern.square_mm, 0, 0, 0, scene_.pattern.origin_dark}; }
  [[nodiscard]] PatternEstimator estimator(const PatternOptions& options = {}) const {
    const PatternView view{scene_.view(), region_};
    return PatternEstimator::make(std::span(&view, 1), surface(), scene_.media, plane(), options).value();
  }
  // rms over the points whose corners lie in the region, mm.
  [[nodiscard]] double error(std::uint64_t number, const Coefficients<double>& a) const {
    const Coefficients<double> truth = scene_.coefficients(number);
    const auto seen = truth_pixels(scene_, number).value();
    const auto points = scene_.points();
    double sum = 0;
    int n = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (seen[i].x() < region_.u0 || seen[i].x() >= region_.u1 || seen[i].y() < region_.v0 || seen[i].y() >= region_.v1)
        continue;
      const double e =
          scene_.surface.height(a, points[i].x(), points[i].y()) - scene_.surface.height(truth, points[i].x(), points[i].y());
      sum += e * e;
      ++n;
    }
    return std::sqrt(sum / n);
  }
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const Region& region() const { return region_; }
  [[nodiscard]] std::vector<std::uint8_t>& pixels() { return pixels_; }

 private:
  Scene scene_;
  Renderer renderer_;
  Region region_;
  std::vector<std::uint8_t> pixels_;
};

Coefficients<double> level_guess(const Scene& scene, double mm) {
  Coefficients<double> a = Coefficients<double>::Zero(scene.surface.modes.size());
  a[0] = mm;
  return a;
}

PatternEstimate estimate(PatternEstimator& estimator, const GrayView& image, const Coefficients<double>& start) {
  return estimator.estimate(std::span(&image, 1), {}, std::span(&start, 1));
}

TEST(BlurredChecker, IsTheMeanOfTheBoardUnderTheBlur) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-2, 2), slant(-0.4, 0.4);
  for (int trial = 0; trial < 12; ++trial) {
    const double x = place(random), y = place(random);
    const BlurFootprint foot{22 + 4 * slant(random), 18, slant(random)};
    for (const double blur : {0.8, 3.5}) {
      const double sx = blur / foot.per_sigma_x, sy = blur / foot.per_sigma_y;
      double sum = 0, weights = 0;
      constexpr int kSteps = 1200;
      for (int i = 0; i < kSteps; ++i) {
        const double p = 5.5 * (2 * (i + 0.5) / kSteps - 1);
        for (int j = 0; j < kSteps / 4; ++j) {
          const double q = 5.5 * (2 * (j + 0.5) / (kSteps / 4) - 1);
          const double weight = std::exp(-0.5 * (p * p + q * q));
          const double at_x = x + sx * p;
          const double at_y = y + sy * (foot.correlation * p + std::sqrt(1 - foot.correlation * foot.correlation) * q);
          const bool dark = (static_cast<int>(std::floor(at_x) + std::floor(at_y)) & 1) == 0;
          sum += dark ? -weight : weight;
          weights += weight;
        }
      }
      EXPECT_NEAR(blurred_checker(x, y, foot, blur).shape, sum / weights, 0.006);
    }
  }
}

TEST(BlurredChecker, DerivativesAreCentralDifferences) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-2, 2), slant(-0.4, 0.4);
  for (int trial = 0; trial < 200; ++trial) {
    const double x = place(random), y = place(random), blur = trial % 2 == 0 ? 1.0 : 4.5, h = 1e-5;
    const BlurFootprint foot{20, 17, slant(random)};
    const CheckerSample at = blurred_checker(x, y, foot, blur);
    const auto shape = [&](double dx, double dy, double db) { return blurred_checker(x + dx, y + dy, foot, blur + db).shape; };
    EXPECT_NEAR(at.by_x, (shape(h, 0, 0) - shape(-h, 0, 0)) / (2 * h), 2e-4);
    EXPECT_NEAR(at.by_y, (shape(0, h, 0) - shape(0, -h, 0)) / (2 * h), 2e-4);
    EXPECT_NEAR(at.by_blur, (shape(0, 0, h) - shape(0, 0, -h)) / (2 * h), 2e-4);
  }
}

// Half the derivative of the cost is J'We: exact, although the levels are solved for anew at every point.
template <class Problem>
void expect_gradient(Problem& problem, const Coefficients<double>& unknowns) {
  NormalEquations at;
  ASSERT_TRUE(problem.evaluate(unknowns, at));
  for (Eigen::Index j = 0; j < unknowns.size(); ++j) {
    const double h = 1e-4;
    NormalEquations plus, minus;
    Coefficients<double> moved = unknowns;
    moved[j] += h;
    ASSERT_TRUE(problem.evaluate(moved, plus));
    moved[j] -= 2 * h;
    ASSERT_TRUE(problem.evaluate(moved, minus));
    const double difference = (plus.cost - minus.cost) / (4 * h);
    EXPECT_NEAR(at.jte[j], difference, 1e-5 * std::abs(difference) + 1e-6 * std::sqrt(at.jtj(j, j) * at.cost)) << j;
  }
}

TEST(PatternProblem, GradientsAreCentralDifferencesOfTheCost) {
  Flume flume;
  const GrayView image = flume.frame(3);
  const Scene& scene = flume.scene();
  for (const bool gradients : {false, true}) {
    PatternProblem problem(scene.view(), flume.region(), flume.surface(), scene.media, flume.plane(), gradients);
    ASSERT_GT(problem.load(image, {}), 5000);
    const Eigen::Index n = scene.surface.modes.size();
    Coefficients<double> unknowns(n + 1);
    unknowns.head(n) = scene.coefficients(3) + Coefficients<double>::Constant(n, 0.4);
    unknowns[n] = 1.1;
    ASSERT_TRUE(problem.start_from(unknowns.head(n)));
    problem.free_blur();
    expect_gradient(problem, unknowns);
    problem.reweigh();
    expect_gradient(problem, unknowns);
    problem.hold_blur(3);
    expect_gradient(problem, unknowns.head(n));
  }
}

TEST(PatternProblem, TheReleasesFormHasExactGradientsToo) {
  Flume flume;
  const GrayView image = flume.frame(0);
  const Scene& scene = flume.scene();
  PatternSurface surface;
  surface.form = SurfaceForm::kLevelAndNormal;
  const Region patch{flume.region().u0 + 60, flume.region().v0 + 30, flume.region().u0 + 130, flume.region().v0 + 85};
  PatternProblem problem(scene.view(), patch, surface, scene.media, flume.plane(), true);
  ASSERT_EQ(problem.load(image, {}), 70 * 55);
  const Coefficients<double> unknowns = fakes::coefficients({79, -2, 0.9});
  ASSERT_TRUE(problem.start_from(unknowns.head(2)));
  problem.free_blur();
  expect_gradient(problem, unknowns);
}

TEST(PatternEstimator, RecoversRenderedSurfacesAsWellAsCornersDo) {
  Flume flume;
  const Scene& scene = flume.scene();
  PatternEstimator estimator = flume.estimator();
  CameraSetup<double> setup{scene.view(), scene.width(), scene.height(), {}};
  const auto points = scene.points();
  SurfaceTrackerOptions options;
  options.detector.min_distance = 6;
  options.search_radius = 4;
  auto tracker = SurfaceTracker<double>::make(std::span(&setup, 1), Pattern::make(points, FirstSquare::kDark).value(),
                                              scene.surface, scene.media, level_guess(scene, 80), EstimatorOptions{}, options)
                     .value();
  double pattern = 0, corners = 0, normalised = 0;
  constexpr int kFrames = 6;
  for (std::uint64_t k = 0; k < kFrames; ++k) {
    const GrayView image = flume.frame(k);
    const auto& tracked = tracker.process(std::span(&image, 1), static_cast<std::int64_t>(k) * 20'000'000);
    ASSERT_TRUE(tracked.has_surface()) << k;
    const PatternEstimate found = estimate(estimator, image, level_guess(scene, 80));
    ASSERT_FALSE(failed(found.surface.stop)) << to_string(found.surface.stop);
    pattern += std::pow(flume.error(k, found.surface.coefficients), 2) / kFrames;
    corners += std::pow(flume.error(k, tracked.estimate.coefficients), 2) / kFrames;
    const Coefficients<double> e = found.surface.coefficients - scene.coefficients(k);
    normalised += e.dot(found.surface.information * e) / (kFrames * static_cast<double>(e.size()));
    EXPECT_GT(found.explained, 0.98);
    // The lens's Gaussian and the pixel's square.
    EXPECT_NEAR(found.images[0].blur_px, std::sqrt(scene.blur_px * scene.blur_px + 1.0 / 12), 0.03);
    EXPECT_NEAR(found.images[0].levels.mean[0] + found.images[0].levels.contrast[0], scene.light.bright, 2);
    EXPECT_NEAR(found.images[0].levels.mean[0] - found.images[0].levels.contrast[0], scene.light.dark, 2);
  }
  RecordProperty("pattern_um", static_cast<int>(1000 * std::sqrt(pattern)));
  RecordProperty("corners_um", static_cast<int>(1000 * std::sqrt(corners)));
  EXPECT_LT(std::sqrt(pattern), 0.03);
  EXPECT_LT(std::sqrt(pattern), 1.1 * std::sqrt(corners));
  // Chi square of 30 over 30, [0.4, 2.1] with 99.9 %; the sandwich's own scatter comes on top.
  EXPECT_GT(normalised, 0.3);
  EXPECT_LT(normalised, 3);
}

TEST(PatternEstimator, FindsTheSurfaceFromAThirdOfASquareOff) {
  // A piece of 6 x 6 squares of the full-size flume, under a plane that leans about the piece's middle: so the whole piece
  // seems to move, up to a third of a square along X and along Y at once.
  Scene scene = default_scene();
  scene.surface = {ModeList::standard(3).value(), 100, 100, 100, 200};
  scene.motions = {{*Mode::parse("A00"), 80, 0, 0, 0}, {*Mode::parse("B"), 1, 0, 0, 0}, {*Mode::parse("C"), -2, 0, 0, 0}};
  Renderer renderer = Renderer::make(scene).value();
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(scene.width() * scene.height()));
  renderer.render(0, {pixels.data(), scene.width(), scene.height(), scene.width()});
  const GrayView image{pixels.data(), scene.width(), scene.height(), scene.width()};
  const auto middle = truth_pixels(scene, 0).value()[static_cast<std::size_t>(5 * scene.pattern.columns + 10)];
  const int u = static_cast<int>(middle.x()), v = static_cast<int>(middle.y());
  const PatternView view{scene.view(), {u - 120, v - 120, u + 120, v + 120}};
  PatternEstimator estimator = PatternEstimator::make(std::span(&view, 1), {SurfaceForm::kModes, scene.surface}, scene.media,
                                                      {scene.pattern.square_mm, 0, 0, 0, scene.pattern.origin_dark}, {})
                                   .value();
  const Coefficients<double> truth = scene.coefficients(0);
  const PatternEstimate best = estimate(estimator, image, truth);
  ASSERT_FALSE(failed(best.surface.stop));
  const double slope = scene.pattern.square_mm / 3 / (truth[0] * (1 - 1 / scene.media.water));
  for (const double across : {-1.0, 1.0})
    for (const double along : {-1.0, 0.0, 1.0}) {
      const Coefficients<double> start =
          truth + fakes::coefficients({0, across * slope * scene.surface.lx, along * slope * scene.surface.ly});
      const PatternEstimate found = estimate(estimator, image, start);
      ASSERT_FALSE(failed(found.surface.stop)) << across << " " << along;
      EXPECT_LT((found.surface.coefficients - best.surface.coefficients).norm(), 0.01) << across << " " << along;
    }
  // Along the line of sight a wrong level moves the pattern, by a third of a square over some 30 mm.
  for (const double level : {-25.0, 25.0}) {
    const PatternEstimate found = estimate(estimator, image, truth + fakes::coefficients({level, 0, 0}));
    ASSERT_FALSE(failed(found.surface.stop)) << level;
    EXPECT_LT((found.surface.coefficients - best.surface.coefficients).norm(), 0.01) << level;
  }
}

TEST(PatternEstimator, LightThatFallsOffAndGlareMoveTheSurfaceLittle) {
  Scene scene = small_scene();
  scene.light.bright = 150;
  scene.light.gradient_percent = 40;
  scene.glare = {{120, 70, 0, 0, 8, 255}, {300, 120, 0, 0, 6, 255}};
  Flume flume(scene);
  PatternEstimator estimator = flume.estimator();
  double sum = 0;
  for (std::uint64_t k = 0; k < 3; ++k) {
    const PatternEstimate found = estimate(estimator, flume.frame(k), level_guess(scene, 80));
    ASSERT_FALSE(failed(found.surface.stop));
    EXPECT_GT(found.images[0].levels.contrast[1], 3);
    sum += std::pow(flume.error(k, found.surface.coefficients), 2) / 3;
  }
  EXPECT_LT(std::sqrt(sum), 0.06);
}

TEST(PatternEstimator, UsesOnlyWhatTheMaskShows) {
  Flume flume;
  const Scene& scene = flume.scene();
  const Region& region = flume.region();
  const GrayView image = flume.frame(2);
  const int width = region.u1 - region.u0, height = region.v1 - region.v0;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(width * height), 1);
  for (int v = 0; v < height / 2; ++v)
    for (int u = 0; u < width / 3; ++u) {
      mask[static_cast<std::size_t>(v * width + u)] = 0;
      flume.pixels()[static_cast<std::size_t>((region.v0 + v) * scene.width() + region.u0 + u)] = 94;
    }
  PatternEstimator estimator = flume.estimator();
  const Coefficients<double> guess = level_guess(scene, 80);
  const std::span<const std::uint8_t> shown = mask;
  const PatternEstimate found = estimator.estimate(std::span(&image, 1), std::span(&shown, 1), std::span(&guess, 1));
  ASSERT_FALSE(failed(found.surface.stop));
  EXPECT_EQ(found.pixels, width * height - width / 3 * (height / 2));
  EXPECT_LT(flume.error(2, found.surface.coefficients), 0.06);
}

TEST(PatternEstimator, SaysWhenThereIsNoPattern) {
  Flume flume;
  const Coefficients<double> guess = level_guess(flume.scene(), 80);
  GrayView image = flume.frame(0);
  PatternEstimator estimator = flume.estimator();
  std::fill(flume.pixels().begin(), flume.pixels().end(), std::uint8_t{94});
  const PatternEstimate blank = estimate(estimator, image, guess);
  EXPECT_EQ(blank.surface.stop, Stop::kOutOfDomain);
  std::mt19937 random(1);
  for (std::uint8_t& pixel : flume.pixels()) pixel = static_cast<std::uint8_t>(random() % 256);
  const PatternEstimate noise = estimate(estimator, image, guess);
  EXPECT_TRUE(failed(noise.surface.stop) || noise.explained < 0.25);
  image.width = 100;
  EXPECT_EQ(estimate(estimator, image, guess).surface.stop, Stop::kTooFewCorners);
  image.width = flume.scene().width();
  EXPECT_EQ(estimate(estimator, flume.frame(0), Coefficients<double>::Constant(5, std::nan(""))).surface.stop,
            Stop::kOutOfDomain);
  EXPECT_EQ(estimate(estimator, image, level_guess(flume.scene(), -20)).surface.stop, Stop::kOutOfDomain);
}

TEST(PatternEstimator, RefusesImpossibleTasks) {
  const Flume flume;
  std::size_t views_given = 1;
  const auto make = [&](Region region, CheckerPlane plane, const PatternOptions& options) {
    const std::vector<PatternView> views(views_given, PatternView{flume.scene().view(), region});
    return PatternEstimator::make(views, flume.surface(), flume.scene().media, plane, options).ok();
  };
  EXPECT_TRUE(make({50, 50, 90, 90}, flume.plane(), {}));
  EXPECT_FALSE(make({50, 50, 57, 90}, flume.plane(), {}));
  EXPECT_FALSE(make({50, 50, 90, 90}, {0, 0, 0, 0, true}, {}));
  PatternOptions options;
  options.scale = {1, 1};
  EXPECT_FALSE(make({50, 50, 90, 90}, flume.plane(), options));
  options.scale = {1, 1, 1, 1, -1};
  EXPECT_FALSE(make({50, 50, 90, 90}, flume.plane(), options));
  views_given = 4;
  EXPECT_TRUE(make({50, 50, 90, 90}, flume.plane(), {}));
  for (const std::size_t wrong : {0U, 5U}) {
    views_given = wrong;
    EXPECT_FALSE(make({50, 50, 90, 90}, flume.plane(), {}));
  }
}

// The flume's camera, and one on the opposite side: half a turn about the pattern's middle. Its light is dim and its sensor noisy.
Scene from_the_other_side(const Scene& scene) {
  Scene out = scene;
  Vec3<double> middle = Vec3<double>::Zero();
  const auto points = scene.points();
  for (const Vec3<double>& point : points) middle += point / static_cast<double>(points.size());
  middle.z() = 0;
  const Vec3<double> half_turn(-1, -1, 1);
  out.pose.rotation = scene.pose.rotation * half_turn.asDiagonal();
  out.pose.translation = scene.pose.translation + scene.pose.rotation * (middle - half_turn.asDiagonal() * middle);
  out.light.bright = 110;
  out.blur_px = 1.0;
  out.noise = 3;
  return out;
}

TEST(PatternViews, TwoCamerasTogetherAreAsGoodAsTheirInformationAdded) {
  Flume near(small_scene()), far(from_the_other_side(small_scene()));
  const Scene& scene = near.scene();
  PatternEstimator one = near.estimator(), other = far.estimator();
  const std::array<PatternView, 2> views{PatternView{scene.view(), near.region()}, {far.scene().view(), far.region()}};
  PatternEstimator both = PatternEstimator::make(views, near.surface(), scene.media, near.plane(), {}).value();
  const Coefficients<double> guess = level_guess(scene, 80);
  std::array<double, 3> squares{};
  double normalised = 0, apart = 0;
  constexpr int kFrames = 6;
  for (std::uint64_t k = 0; k < kFrames; ++k) {
    const std::array<GrayView, 2> images{near.frame(k), far.frame(k)};
    const PatternEstimate a = estimate(one, images[0], guess), b = estimate(other, images[1], guess);
    const PatternEstimate joint = both.estimate(images, {}, std::span(&guess, 1));
    ASSERT_FALSE(failed(joint.surface.stop)) << to_string(joint.surface.stop);
    EXPECT_EQ(joint.pixels, a.pixels + b.pixels);
    EXPECT_NEAR(joint.images[1].blur_px, std::sqrt(1 + 1.0 / 12), 0.05);
    EXPECT_NEAR(joint.images[1].levels.mean[0] + joint.images[1].levels.contrast[0], 110, 2);
    for (const auto& [i, found] : {std::pair{0U, &a}, {1U, &b}, {2U, &joint}})
      squares[i] += std::pow(near.error(k, found->surface.coefficients), 2) / kFrames;
    const Coefficients<double> e = joint.surface.coefficients - scene.coefficients(k);
    normalised += e.dot(joint.surface.information * e) / (kFrames * static_cast<double>(e.size()));
    // (18), in deviations of the sum.
    const InformationMatrix<double> sum = a.surface.information + b.surface.information;
    const Coefficients<double> added =
        sum.llt().solve(a.surface.information * a.surface.coefficients + b.surface.information * b.surface.coefficients);
    const Coefficients<double> off = joint.surface.coefficients - added;
    apart += off.dot(sum * off) / (kFrames * static_cast<double>(e.size()));
  }
  EXPECT_LT(squares[2], squares[0]);
  EXPECT_LT(squares[2], squares[1]);
  EXPECT_LT(apart, 0.5);
  EXPECT_GT(normalised, 0.3);
  EXPECT_LT(normalised, 3);
  RecordProperty("one_um", static_cast<int>(1000 * std::sqrt(squares[0])));
  RecordProperty("other_um", static_cast<int>(1000 * std::sqrt(squares[1])));
  RecordProperty("both_um", static_cast<int>(1000 * std::sqrt(squares[2])));
}

TEST(PatternViews, GradientsAreCentralDifferencesOfTheCost) {
  Flume near(small_scene()), far(from_the_other_side(small_scene()));
  const Scene& scene = near.scene();
  std::vector<PatternProblem> problems;
  problems.emplace_back(scene.view(), near.region(), near.surface(), scene.media, near.plane(), false);
  problems.emplace_back(far.scene().view(), far.region(), near.surface(), scene.media, near.plane(), false);
  PatternViews joint(std::move(problems));
  ASSERT_GT(joint.load(std::array{near.frame(3), far.frame(3)}, {}), 10000);
  const Eigen::Index n = scene.surface.modes.size();
  Coefficients<double> unknowns(n + 2);
  unknowns.head(n) = scene.coefficients(3) + Coefficients<double>::Constant(n, 0.4);
  unknowns.tail<2>() << 1.1, 0.8;
  ASSERT_TRUE(joint.start_from(unknowns.head(n)));
  joint.free_blur();
  expect_gradient(joint, unknowns);
  joint.reweigh();
  expect_gradient(joint, unknowns);
  joint.hold_blur(0.2);
  expect_gradient(joint, unknowns.head(n));
}

TEST(PatternViews, ACameraWithoutPatternIsNoFit) {
  Flume near(small_scene()), far(from_the_other_side(small_scene()));
  const std::array<PatternView, 2> views{PatternView{near.scene().view(), near.region()}, {far.scene().view(), far.region()}};
  PatternEstimator both = PatternEstimator::make(views, near.surface(), near.scene().media, near.plane(), {}).value();
  const Coefficients<double> guess = level_guess(near.scene(), 80);
  std::array<GrayView, 2> images{near.frame(0), far.frame(0)};
  EXPECT_EQ(both.estimate(std::span(images).first(1), {}, std::span(&guess, 1)).surface.stop, Stop::kTooFewCorners);
  std::fill(far.pixels().begin(), far.pixels().end(), std::uint8_t{94});
  EXPECT_TRUE(failed(both.estimate(images, {}, std::span(&guess, 1)).surface.stop));
}

TEST(PatternEstimator, AllocatesNothing) {
  Flume flume;
  PatternEstimator estimator = flume.estimator();
  const GrayView image = flume.frame(0);
  const Coefficients<double> guess = level_guess(flume.scene(), 80);
  (void)estimate(estimator, image, guess);
  fakes::AllocationGauge gauge;
  (void)estimate(estimator, image, guess);
  EXPECT_EQ(gauge.count(), 0U);
}

}  // namespace
}  // namespace srd::dsp
