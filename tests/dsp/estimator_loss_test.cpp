// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "dsp/estimate/solver/loss.hpp"
#include "tests/dsp/estimator_fixture.hpp"

namespace srd::dsp {
namespace {

// Corners with Gaussian noise, some of them pushed 3 to 30 px off in any direction.
template <class S>
class NoisyCorners {
 public:
  NoisyCorners(Fit<S>& fit, std::uint64_t seed) : fit_(fit), random_(seed) {
    fit.observe();
    exact_ = fit.seen;
  }

  void draw(double gross_share) {
    std::normal_distribution<double> normal(0, kCornerNoise);
    std::uniform_real_distribution<double> one(0, 1);
    for (std::size_t view = 0; view < exact_.size(); ++view)
      for (std::size_t i = 0; i < exact_[view].size(); ++i) {
        Vec2<double> off(normal(random_), normal(random_));
        if (one(random_) < gross_share) {
          const double size = 3 + 27 * one(random_), direction = 2 * fakes::kPi * one(random_);
          off += size * Vec2<double>(std::cos(direction), std::sin(direction));
        }
        Observation<S>& corner = fit_.seen[view][i];
        corner.pixel = exact_[view][i].pixel + off.template cast<S>();
        corner.sigma = static_cast<S>(kCornerNoise);
        corner.normalised = fit_.views[view].camera.undistort(corner.pixel).value();
      }
  }

 private:
  Fit<S>& fit_;
  std::mt19937_64 random_;
  std::deque<std::vector<Observation<S>>> exact_{};
};

TEST(ScaledLoss, WeightAndDerivativeAreThoseOfItsRho) {
  for (const Loss kind : {Loss::kNone, Loss::kHuber, Loss::kTukey}) {
    const ScaledLoss loss{kind, 0.7};
    const auto psi = [&](double r) { return r * loss.at(r * r).weight; };
    for (double r = 0.01; r < 6; r += 0.0937) {
      const double h = 1e-5, s = r * r;
      EXPECT_NEAR((loss.at(s + h).rho - loss.at(s - h).rho) / (2 * h), loss.at(s).weight, 1e-7) << r;
      EXPECT_NEAR((psi(r + h) - psi(r - h)) / (2 * h), loss.at(s).derivative, 1e-7) << r;
    }
  }
}

TEST(ScaledLoss, KeepsNineteenTwentiethsOfThePrecisionOnGaussianNoise) {
  // Of two components: (E[(psi' + psi/r)/2])^2 / (E[psi^2]/2), r Rayleigh distributed.
  for (const Loss kind : {Loss::kHuber, Loss::kTukey}) {
    const ScaledLoss loss{kind, 1};
    double slope = 0, square = 0;
    constexpr double kStep = 1e-3;
    for (double r = kStep / 2; r < 12; r += kStep) {
      const ScaledLoss::Value value = loss.at(r * r);
      const double density = r * std::exp(-r * r / 2) * kStep;
      slope += density * (value.weight + value.derivative) / 2;
      square += density * value.weight * value.weight * r * r / 2;
    }
    EXPECT_NEAR(slope * slope / square, 0.95, 0.001);
  }
}

// Metric, loss, share of gross corners, scalar is float.
class RobustMonteCarlo : public testing::TestWithParam<std::tuple<Metric, Loss, double, bool>> {
 protected:
  template <class S>
  void compare(int parameters, double limit) {
    constexpr int kRobustDraws = 1600;
    const auto [metric, loss, gross, narrow] = GetParam();
    EstimatorOptions options;
    options.metric = metric;
    options.loss = loss;
    Fit<S> fit(fakes::flume_scene(parameters, 1), options);
    NoisyCorners<S> corners(fit, 7);
    auto estimator = fit.estimator();
    const Coefficients<S> start = fit.scene.truth.template cast<S>();
    Coefficients<double> sum = Coefficients<double>::Zero(parameters), squares = sum, variances = sum;
    double used = 0;
    for (int draw = 0; draw < kRobustDraws; ++draw) {
      corners.draw(gross);
      const auto found = estimator.estimate(fit.cameras(), std::span(&start, 1));
      ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
      const Coefficients<double> error = found.coefficients.template cast<double>() - fit.scene.truth;
      sum += error;
      squares += error.cwiseAbs2();
      variances += found.standard_deviation.template cast<double>().cwiseAbs2();
      used += found.corners_used / 231.0 / kRobustDraws;
    }
    for (int j = 0; j < parameters; ++j) {
      const double mean = sum[j] / kRobustDraws, scatter = squares[j] / kRobustDraws - mean * mean;
      const double ratio = std::sqrt(scatter / (variances[j] / kRobustDraws));
      EXPECT_NEAR(ratio, 1, limit) << "coefficient " << j;
      RecordProperty("scatter_over_stated_" + std::to_string(j), std::to_string(ratio));
    }
    if (loss == Loss::kTukey) {
      EXPECT_NEAR(used, 1 - gross, 0.002);
    }
  }
};

TEST_P(RobustMonteCarlo, ScatterIsTheStatedDeviation) {
  const double limit = std::get<2>(GetParam()) > 0 ? 0.10 : 0.05;
  if (std::get<3>(GetParam()))
    compare<float>(8, limit);
  else
    compare<double>(5, limit);
}

std::string robust_name(const testing::TestParamInfo<std::tuple<Metric, Loss, double, bool>>& info) {
  static constexpr const char* kMetricNames[] = {"Reprojection", "Disparity", "Collinearity"};
  static constexpr const char* kLossNames[] = {"None", "Huber", "Tukey"};
  const auto [metric, loss, gross, narrow] = info.param;
  return std::string(kMetricNames[static_cast<int>(metric)]) + kLossNames[static_cast<int>(loss)] +
         (gross > 0 ? "GrossCorners" : "Gaussian") + (narrow ? "InFloat" : "InDouble");
}

INSTANTIATE_TEST_SUITE_P(SlowEstimator, RobustMonteCarlo,
                         testing::Combine(testing::Values(Metric::kReprojection, Metric::kDisparity),
                                          testing::Values(Loss::kHuber, Loss::kTukey), testing::Values(0.0, 0.05),
                                          testing::Values(false)),
                         robust_name);
INSTANTIATE_TEST_SUITE_P(SlowEstimatorInFloat, RobustMonteCarlo,
                         testing::Combine(testing::Values(Metric::kReprojection), testing::Values(Loss::kTukey),
                                          testing::Values(0.0, 0.05), testing::Values(true)),
                         robust_name);

TEST(EstimatorLoss, GrossCornersCostLittleWithTukeyAndMuchWithout) {
  std::array<double, 3> errors{};
  for (const Loss loss : {Loss::kNone, Loss::kHuber, Loss::kTukey}) {
    EstimatorOptions options;
    options.loss = loss;
    Fit<double> fit(fakes::flume_scene(8, 1), options);
    NoisyCorners<double> corners(fit, 3);
    corners.draw(0.2);
    const auto found = fit.from_flat();
    ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
    errors[static_cast<std::size_t>(loss)] = fit.scene.surface_error(found.coefficients);
    if (loss == Loss::kNone) {
      EXPECT_EQ(found.loss_scale, 0);
      continue;
    }
    // In sigmas: a fifth of the corners that are far off moves the median a little.
    EXPECT_NEAR(found.loss_scale, 1.2, 0.2);
    if (loss == Loss::kTukey) {
      EXPECT_LT(found.corners_used, 200);
      EXPECT_NEAR(found.reprojection_rms, kCornerNoise, 0.01);
      // Chi-square with 8 degrees of freedom: one in 2000 is above.
      const Coefficients<double> error = found.coefficients - fit.scene.truth;
      EXPECT_LT(error.dot(found.information * error), 27.9);
    } else {
      EXPECT_EQ(found.corners_used, 231);
    }
  }
  EXPECT_GT(errors[0], 10 * errors[2]);
  EXPECT_GT(errors[0], 3 * errors[1]);
}

// Every metric, with corners that something has touched: the surface is off by what it says of itself, and it says no
// more than twice what it would without them.
TEST(EstimatorLoss, HoldsWithGrossCornersInEveryMetric) {
  for (const Metric metric : kMetrics)
    for (const Loss loss : {Loss::kHuber, Loss::kTukey})
      for (const double gross : {0.0, 0.05, 0.10, 0.15})
        for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
          EstimatorOptions options;
          options.metric = metric;
          options.loss = loss;
          Fit<double> fit(fakes::flume_scene(8, 1), options);
          NoisyCorners<double> corners(fit, seed);
          corners.draw(gross);
          const auto found = fit.from_flat();
          ASSERT_FALSE(failed(found.stop)) << to_string(found.stop) << " metric " << static_cast<int>(metric) << " loss "
                                           << to_string(loss) << " gross " << gross << " seed " << seed;
          corners.draw(0);
          const auto clean = fit.from_flat();
          ASSERT_FALSE(failed(clean.stop));
          EXPECT_LT(found.height_deviation, 2 * clean.height_deviation) << static_cast<int>(metric) << " " << gross;
          EXPECT_LT(fit.scene.surface_error(found.coefficients), 4 * found.height_deviation)
              << static_cast<int>(metric) << " " << gross << " " << seed;
        }
}

TEST(EstimatorLoss, ErrorSizesAreOfTheFinalSurfaceWhateverTheMetric) {
  std::vector<double> pixels;
  for (const Metric metric : {Metric::kReprojection, Metric::kDisparity}) {
    EstimatorOptions options;
    options.metric = metric;
    options.loss = Loss::kTukey;
    Fit<double> fit(fakes::flume_scene(8, 1), options);
    auto estimator = fit.estimator();
    const Coefficients<double> start = fit.scene.truth;
    // The first fit leaves sizes behind that the second has to replace.
    for (const std::uint64_t seed : {4u, 3u}) {
      NoisyCorners<double> corners(fit, seed);
      corners.draw(0.1);
      const auto all = fit.cameras();
      const auto found = estimator.estimate(all, std::span(&start, 1));
      ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
    }
    std::vector<double> sizes(231);
    estimator.error_sizes(sizes);
    if (metric == Metric::kReprojection) {
      pixels = sizes;
      EXPECT_GT(*std::max_element(sizes.begin(), sizes.end()), 3 / kCornerNoise);
      continue;
    }
    for (std::size_t i = 0; i < sizes.size(); ++i) EXPECT_NEAR(sizes[i], pixels[i], 0.5 + 0.1 * pixels[i]) << i;
  }
}

TEST(EstimatorLoss, ExactCornersStillGiveTheSurface) {
  for (const Metric metric : kMetrics)
    for (const Loss loss : {Loss::kHuber, Loss::kTukey}) {
      EstimatorOptions options;
      options.metric = metric;
      options.loss = loss;
      Fit<double> wide(fakes::flume_scene(12, 2), options);
      const auto found = wide.from_flat();
      ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
      EXPECT_LE(wide.scene.surface_error(found.coefficients), 1e-6);
      Fit<float> narrow(fakes::flume_scene(12, 2), options);
      const auto found_float = narrow.from_flat();
      ASSERT_FALSE(failed(found_float.stop)) << to_string(found_float.stop);
      EXPECT_LE(narrow.scene.surface_error(found_float.coefficients), 1e-3);
    }
}

TEST(EstimatorLoss, StepsAreBoundedOverAllTurns) {
  EstimatorOptions options;
  options.loss = Loss::kTukey;
  options.max_iterations = 6;
  Fit<double> fit(fakes::flume_scene(8, 1), options);
  NoisyCorners<double> corners(fit, 3);
  corners.draw(0.1);
  // One step a turn may come on top.
  EXPECT_LE(fit.from_flat().iterations, 6 + 3);
}

TEST(EstimatorLoss, TheDeadlineHoldsInEveryTurn) {
  for (int steps = 0; steps < 6; ++steps) {
    int left = steps;
    EstimatorOptions options;
    options.loss = Loss::kTukey;
    options.deadline_context = &left;
    options.deadline = [](void* context) { return (*static_cast<int*>(context))-- <= 0; };
    Fit<double> fit(fakes::flume_scene(8, 1), options);
    NoisyCorners<double> corners(fit, 3);
    corners.draw(0.1);
    const auto found = fit.from_flat();
    EXPECT_EQ(found.stop, Stop::kDeadline);
    EXPECT_LE(found.iterations, steps);
    EXPECT_TRUE(found.coefficients.allFinite());
    EXPECT_GE(left, -1);
  }
}

}  // namespace
}  // namespace srd::dsp
