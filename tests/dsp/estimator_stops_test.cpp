// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/dsp/estimator_fixture.hpp"

namespace srd::dsp {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Fit<double> noisy_fit(EstimatorOptions options, int parameters = 5) {
  Fit<double> fit(fakes::flume_scene(parameters, 1), std::move(options));
  std::mt19937_64 random(11);
  fit.observe(0.1, &random);
  return fit;
}

TEST(EstimatorStops, OnTheGradient) {
  EstimatorOptions options;
  options.epsg = 1e-3;
  auto fit = noisy_fit(options);
  EXPECT_EQ(fit.from_flat().stop, Stop::kGradient);
}

TEST(EstimatorStops, OnTheCost) {
  EstimatorOptions options;
  options.epsf = 1e-6;
  auto fit = noisy_fit(options);
  EXPECT_EQ(fit.from_flat().stop, Stop::kCost);
}

TEST(EstimatorStops, OnTheStep) {
  EstimatorOptions options;
  options.epsx = 1e-4;
  auto fit = noisy_fit(options);
  EXPECT_EQ(fit.from_flat().stop, Stop::kStep);
}

TEST(EstimatorStops, OnTheNumberOfIterations) {
  EstimatorOptions options;
  options.max_iterations = 1;
  auto fit = noisy_fit(options);
  const auto found = fit.from_flat();
  EXPECT_EQ(found.stop, Stop::kMaxIterations);
  EXPECT_EQ(found.iterations, 1);
}

TEST(EstimatorStops, OnTheDeadlineWithTheBestSoFar) {
  int calls = 0;
  EstimatorOptions options;
  options.deadline_context = &calls;
  options.deadline = [](void* context) { return ++*static_cast<int*>(context) > 1; };
  auto fit = noisy_fit(options);
  const auto found = fit.from_flat();
  EXPECT_EQ(found.stop, Stop::kDeadline);
  EXPECT_FALSE(failed(found.stop));
  EXPECT_EQ(found.iterations, 1);
  // One step is most of the way from 5 mm.
  EXPECT_LT(fit.scene.surface_error(found.coefficients), 1.0);
}

TEST(EstimatorStops, WhenTheArithmeticHasNoMoreToGive) {
  EstimatorOptions options;
  options.max_iterations = 1000;  // the only rule: the others are off
  auto fit = noisy_fit(options);
  const auto found = fit.from_flat();
  EXPECT_EQ(found.stop, Stop::kNoProgress);
  EXPECT_LT(found.iterations, 20);
  Fit<float> narrow(fakes::flume_scene(12, 1), options);
  const auto found_float = narrow.from_flat();
  EXPECT_EQ(found_float.stop, Stop::kNoProgress);
  EXPECT_LT(found_float.iterations, 20);
}

TEST(EstimatorStops, AnswersAgreeWhicheverRuleStopped) {
  EstimatorOptions thorough;
  thorough.max_iterations = 1000;
  auto reference_fit = noisy_fit(thorough);
  const auto reference = reference_fit.from_flat();
  for (const int rule : {0, 1, 2}) {
    EstimatorOptions options;
    (rule == 0 ? options.epsg : rule == 1 ? options.epsf : options.epsx) = 1e-9;
    auto fit = noisy_fit(options);
    const auto found = fit.from_flat();
    EXPECT_LT((found.coefficients - reference.coefficients).cwiseAbs().maxCoeff(), 1e-5) << rule;
  }
}

TEST(EstimatorStops, WithTooFewCorners) {
  for (const int parameters : {3, 5, 8, 12}) {
    Fit<double> fit(fakes::flume_scene(parameters, 1), {});
    fit.observe();
    const auto all = fit.seen[0];
    const int least = (parameters + 1) / 2;
    fit.seen[0].assign(all.begin(), all.begin() + least - 1);
    EXPECT_EQ(fit.from_flat().stop, Stop::kTooFewCorners) << parameters;
    fit.seen[0].clear();
    for (int i = 0; i < least; ++i) fit.seen[0].push_back(all[static_cast<std::size_t>(i * 61 % 231)]);
    EXPECT_NE(fit.from_flat().stop, Stop::kTooFewCorners) << parameters;
  }
  Fit<double> none(fakes::flume_scene(1, 1), {});
  none.observe();
  none.seen[0].clear();
  EXPECT_EQ(none.from_flat().stop, Stop::kTooFewCorners);
}

TEST(EstimatorStops, AsSingularWhenAllCornersLieOnOneLine) {
  for (const Metric metric : kMetrics) {
    EstimatorOptions options;
    options.metric = metric;
    const auto one_row = [](std::vector<Observation<double>> corners) {
      std::erase_if(corners, [](const auto& corner) { return corner.point / 21 != 4; });
      return corners;
    };
    // Along one row A10 and A00 and B cannot be told apart.
    Fit<double> fit(fakes::flume_scene(5, 1), options);
    fit.observe();
    fit.seen[0] = one_row(fit.seen[0]);
    EXPECT_EQ(fit.from_flat().stop, Stop::kSingular) << static_cast<int>(metric);
    // A plane is determined: its slope across the row bends the rays.
    Fit<double> plane(fakes::flume_scene(3, 1), options);
    plane.observe();
    plane.seen[0] = one_row(plane.seen[0]);
    const auto found = plane.from_flat();
    ASSERT_FALSE(failed(found.stop)) << static_cast<int>(metric);
    EXPECT_LT(plane.scene.surface_error(found.coefficients), 1e-6);
  }
}

template <class S>
void expect_singular_with_coincident_corners() {
  for (const Metric metric : kMetrics)
    for (const int parameters : {3, 12}) {
      EstimatorOptions options;
      options.metric = metric;
      Fit<S> fit(fakes::flume_scene(parameters, 1), options);
      fit.observe();
      std::fill(fit.seen[0].begin(), fit.seen[0].end(), fit.seen[0][100]);
      const auto found = fit.from_flat();
      EXPECT_EQ(found.stop, Stop::kSingular) << static_cast<int>(metric) << ' ' << parameters;
    }
}
TEST(EstimatorStops, AsSingularWhenAllCornersAreTheSame) {
  expect_singular_with_coincident_corners<double>();
  expect_singular_with_coincident_corners<float>();
}

TEST(EstimatorStops, AtANanOrInfinityNeverAsConverged) {
  for (const Metric metric : kMetrics)
    for (const double bad : {kNan, std::numeric_limits<double>::infinity()})
      for (const int where : {0, 1, 2}) {
        EstimatorOptions options;
        options.metric = metric;
        auto fit = noisy_fit(options);
        auto& corner = fit.seen[0][17];
        (where == 0 ? corner.pixel.y() : where == 1 ? corner.normalised.x() : corner.sigma) = bad;
        const auto found = fit.from_flat();
        EXPECT_TRUE(failed(found.stop));
        EXPECT_EQ(found.stop, Stop::kNonFinite);
      }
  auto fit = noisy_fit({});
  EXPECT_EQ(fit.from(fakes::level(5, kNan)).stop, Stop::kNonFinite);
  fit.views[0].pose.translation.x() = kNan;
  EXPECT_EQ(fit.from_flat().stop, Stop::kNonFinite);
}

TEST(EstimatorStops, OutsideTheDomainOfEveryStart) {
  for (const Metric metric : kMetrics)
    for (const double level : {-30.0, 2000.0}) {
      EstimatorOptions options;
      options.metric = metric;
      auto fit = noisy_fit(options);
      EXPECT_EQ(fit.from(fakes::level(5, level)).stop, Stop::kOutOfDomain);
    }
}

TEST(EstimatorStops, AtInputThatIsAMistake) {
  auto fit = noisy_fit({});
  const auto good = fit.seen[0];
  EXPECT_EQ(fit.from(fakes::level(3, 80)).stop, Stop::kInvalidInput);
  fit.seen[0][3].point = 231;
  EXPECT_EQ(fit.from_flat().stop, Stop::kInvalidInput);
  fit.seen[0][3].point = -1;
  EXPECT_EQ(fit.from_flat().stop, Stop::kInvalidInput);
  fit.seen[0] = good;
  fit.seen[0][3].sigma = 0;
  EXPECT_EQ(fit.from_flat().stop, Stop::kInvalidInput);
  fit.seen[0] = good;
  while (fit.seen[0].size() <= 2000) fit.seen[0].push_back(good[0]);
  EXPECT_EQ(fit.from_flat().stop, Stop::kInvalidInput);
  fit.seen[0] = good;
  auto cameras = fit.cameras();
  cameras[0].view = nullptr;
  const Coefficients<double> start = fakes::level(5, 80);
  auto estimator = fit.estimator();
  EXPECT_EQ(estimator.estimate(cameras, std::span(&start, 1)).stop, Stop::kInvalidInput);
  EXPECT_EQ(estimator.estimate(fit.cameras(), {}).stop, Stop::kInvalidInput);
}

TEST(EstimatorStops, AStepOutOfTheDomainIsRefusedNotFatal) {
  // From deep water the first full steps pass below the bottom of the shallow end or above the camera.
  fakes::Scene scene = fakes::flume_scene(12, 1);
  scene.truth = 0.2 * fakes::wavy(12);
  scene.truth[0] = 4;
  Fit<double> fit(scene, {});
  const auto found = fit.from(fakes::level(12, 300));
  ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
  EXPECT_LE(scene.surface_error(found.coefficients), 1e-6);
}

TEST(EstimatorBounds, HoldAndAreReported) {
  for (const Metric metric : kMetrics) {
    EstimatorOptions options;
    options.metric = metric;
    options.lower = {60, -5, -1.0, -5, -5};  // truth of C is -2.1
    options.upper = {100, 5, 5, 2.0, 5};     // truth of A10 is 3
    Fit<double> fit(fakes::flume_scene(5, 1), options);
    const auto found = fit.from_flat();
    ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
    EXPECT_TRUE(found.at_bound);
    EXPECT_EQ(found.coefficients[2], -1.0);
    EXPECT_EQ(found.coefficients[3], 2.0);
    EXPECT_LT(found.iterations, 30);
  }
}

TEST(EstimatorBounds, GiveTheConstrainedOptimum) {
  // Fixing two coefficients by equal bounds must give what a model without them gives when they are zero.
  fakes::Scene scene = fakes::flume_scene(5, 1);
  scene.truth[3] = scene.truth[4] = 0;
  EstimatorOptions options;
  options.lower = {0, -50, -50, 0, 0};
  options.upper = {200, 50, 50, 0, 0};
  Fit<double> bounded(scene, options);
  std::mt19937_64 random(3);
  bounded.observe(0.1, &random);
  fakes::Scene plane = scene;
  plane.model.modes = ModeList::standard(3).value();
  plane.truth = scene.truth.head(3);
  Fit<double> free(plane, {});
  std::mt19937_64 again(3);
  free.observe(0.1, &again);
  const auto with = bounded.from_flat();
  const auto without = free.from_flat();
  ASSERT_FALSE(failed(with.stop)) << to_string(with.stop);
  EXPECT_LT((with.coefficients.head(3) - without.coefficients).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(EstimatorBounds, ThatDoNotMatterChangeNothing) {
  EstimatorOptions options;
  options.lower = {0, -20, -20, -20, -20};
  options.upper = {200, 20, 20, 20, 20};
  auto fit = noisy_fit(options);
  auto free = noisy_fit({});
  const auto with = fit.from_flat(), without = free.from_flat();
  EXPECT_FALSE(with.at_bound);
  EXPECT_LT((with.coefficients - without.coefficients).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(EstimatorBounds, PullAStartIntoTheBox) {
  EstimatorOptions options;
  options.lower = {70, -20, -20, -20, -20};
  options.upper = {90, 20, 20, 20, 20};
  auto fit = noisy_fit(options);
  auto free = noisy_fit({});
  const auto found = fit.from(fakes::level(5, 140));
  ASSERT_FALSE(failed(found.stop));
  EXPECT_LT((found.coefficients - free.from_flat().coefficients).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(EstimatorScale, ChangesThePathNotTheAnswer) {
  auto plain = noisy_fit({}, 12);
  EstimatorOptions options;
  options.scale.assign(12, 1.0);
  for (std::size_t i = 0; i < 12; ++i) options.scale[i] = i % 2 == 0 ? 100 : 0.01;
  auto scaled = noisy_fit(options, 12);
  // Far enough off that steps are refused and the damping, which the scale shapes, decides the way.
  const auto start = fakes::level(12, 400);
  const auto one = plain.from(start), other = scaled.from(start);
  ASSERT_FALSE(failed(one.stop)) << to_string(one.stop);
  ASSERT_FALSE(failed(other.stop)) << to_string(other.stop);
  EXPECT_LT(plain.scene.surface_error(other.coefficients), 0.1);
  EXPECT_LT((one.coefficients - other.coefficients).cwiseAbs().maxCoeff(), 1e-5);
  // The step rule measures in units of the scale: coarse units stop earlier.
  EstimatorOptions fine, coarse;
  fine.epsx = coarse.epsx = 1e-6;
  fine.scale.assign(12, 1e-3);
  coarse.scale.assign(12, 1e6);
  auto fine_fit = noisy_fit(fine, 12), coarse_fit = noisy_fit(coarse, 12);
  EXPECT_GT(fine_fit.from_flat().iterations, coarse_fit.from_flat().iterations);
}

}  // namespace
}  // namespace srd::dsp
