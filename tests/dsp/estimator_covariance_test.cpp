// SPDX-License-Identifier: Apache-2.0
// Stated uncertainty against scatter: many draws of corner noise, one true surface.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "dsp/estimate/solver/cholesky.hpp"
#include "tests/dsp/estimator_fixture.hpp"

namespace srd::dsp {
namespace {

constexpr int kDraws = 400;
// Every limit below is this many standard deviations of its own statistic: with some 300 checks on a true statement,
// one in 500 runs of other seeds would fail.
constexpr double kSigmas = 4.5;

// Metric, parameters, cameras, scalar is float.
class MonteCarlo : public testing::TestWithParam<std::tuple<Metric, int, int, bool>> {
 protected:
  template <class S>
  void compare() {
    const auto [metric, parameters, cameras, narrow] = GetParam();
    EstimatorOptions options;
    options.metric = metric;
    Fit<S> fit(fakes::flume_scene(parameters, cameras), options);
    fit.observe();
    const auto exact = fit.seen;
    auto estimator = fit.estimator();
    const Coefficients<S> start = fakes::level(parameters, 82).cast<S>();
    std::mt19937_64 random(static_cast<std::uint64_t>(100 * parameters + cameras));
    std::normal_distribution<double> normal(0, kCornerNoise);

    Coefficients<double> sum = Coefficients<double>::Zero(parameters), squares = sum, variances = sum;
    double nees = 0, factor = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      for (std::size_t view = 0; view < exact.size(); ++view)
        for (std::size_t i = 0; i < exact[view].size(); ++i) {
          Observation<S>& corner = fit.seen[view][i];
          for (int axis = 0; axis < 2; ++axis) corner.pixel[axis] = exact[view][i].pixel[axis] + static_cast<S>(normal(random));
          corner.sigma = static_cast<S>(kCornerNoise);
          corner.normalised = fit.views[view].camera.undistort(corner.pixel).value();
        }
      const auto found = estimator.estimate(fit.cameras(), std::span(&start, 1));
      ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
      const Coefficients<double> error = found.coefficients.template cast<double>() - fit.scene.truth;
      const Coefficients<double> deviation = found.standard_deviation.template cast<double>();
      sum += error;
      squares += error.cwiseAbs2();
      variances += deviation.cwiseAbs2();
      const InformationMatrix<double> information = found.information.template cast<double>();
      nees += error.dot(information * error);
      factor += static_cast<double>(found.variance_factor);
    }
    const double freedom = 462.0 * cameras - parameters;
    // The same pixel error turns the normal less under deeper water, so the smallest sum of angles lies a little too
    // deep: the metric's own bias, up to half a deviation at this noise. The others have none that 400 draws can show.
    const double bias = metric == Metric::kCollinearity ? 0.6 : 0;
    for (int j = 0; j < parameters; ++j) {
      const double stated = variances[j] / kDraws, mean = sum[j] / kDraws;
      const double scatter = squares[j] / kDraws - mean * mean;
      EXPECT_NEAR(scatter / stated, 1, kSigmas * std::sqrt(2.0 / kDraws)) << "coefficient " << j;
      EXPECT_LE(std::abs(mean), kSigmas * std::sqrt(stated / kDraws) + bias * std::sqrt(stated)) << "coefficient " << j;
    }
    if (metric != Metric::kCollinearity) {
      // Sum of squares normalised by the stated information: p times an F distribution's mean.
      const double expected = parameters * freedom / (freedom - 2);
      EXPECT_NEAR(nees / kDraws, expected, kSigmas * std::sqrt(2.0 * parameters / kDraws) * 1.05);
    }
    // Ray metrics do not minimise the pixel residuals, which adds up to p / freedom of them.
    const double slack = metric == Metric::kReprojection ? 0 : parameters / freedom;
    EXPECT_NEAR(factor / kDraws, 1, kSigmas * std::sqrt(2 / freedom / kDraws) + slack);
  }
};

TEST_P(MonteCarlo, ScatterIsTheStatedDeviation) {
  if (std::get<3>(GetParam()))
    compare<float>();
  else
    compare<double>();
}

std::string scatter_name(const testing::TestParamInfo<std::tuple<Metric, int, int, bool>>& info) {
  static constexpr const char* kNames[] = {"Reprojection", "Disparity", "Collinearity"};
  const auto [metric, parameters, cameras, narrow] = info.param;
  return std::string(kNames[static_cast<int>(metric)]) + std::to_string(parameters) + "ParametersFrom" +
         std::to_string(cameras) + (narrow ? "CamerasInFloat" : "CamerasInDouble");
}

INSTANTIATE_TEST_SUITE_P(Estimator, MonteCarlo,
                         testing::Combine(testing::ValuesIn(kMetrics), testing::Values(5, 12), testing::Values(1, 2),
                                          testing::Values(false)),
                         scatter_name);
INSTANTIATE_TEST_SUITE_P(EstimatorInFloat, MonteCarlo,
                         testing::Combine(testing::ValuesIn(kMetrics), testing::Values(8), testing::Values(1),
                                          testing::Values(true)),
                         scatter_name);

TEST(EstimatorCovariance, DeviationsAreTheInverseOfTheInformation) {
  for (const Metric metric : kMetrics) {
    EstimatorOptions options;
    options.metric = metric;
    Fit<double> fit(fakes::flume_scene(12, 2), options);
    std::mt19937_64 random(2);
    fit.observe(kCornerNoise, &random);
    const auto found = fit.from_flat();
    ASSERT_FALSE(failed(found.stop));
    ScaledCholesky factors;
    ASSERT_TRUE(factors.factor(found.information));
    const Coefficients<double> deviation = factors.inverse().diagonal().cwiseSqrt();
    EXPECT_LT((deviation - found.standard_deviation).cwiseQuotient(deviation).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_EQ((found.information - found.information.transpose()).norm(), 0);
  }
}

TEST(EstimatorCovariance, HeightDeviationIsTheRootMeanSquareOverThePattern) {
  for (const bool free_index : {false, true})
    for (const Metric metric : kMetrics) {
      EstimatorOptions options;
      options.metric = metric;
      options.free_index = free_index;
      Fit<double> fit(fakes::flume_scene(12, 3), options);
      std::mt19937_64 random(2);
      fit.observe(kCornerNoise, &random);
      const auto found = fit.from_flat();
      ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
      ScaledCholesky factors;
      ASSERT_TRUE(factors.factor(found.information));
      const InformationMatrix<double> covariance = factors.inverse();
      double sum = 0;
      for (const auto& point : fit.scene.points) {
        Basis<double> basis;
        fit.scene.model.basis(point.x(), point.y(), basis);
        sum += basis.value.dot(covariance * basis.value);
      }
      const double truth = std::sqrt(sum / static_cast<double>(fit.scene.points.size()));
      EXPECT_NEAR(found.height_deviation / truth, 1, 1e-6);
    }
}

TEST(EstimatorCovariance, ReprojectionIsTheMostPrecise) {
  // It weights by the pixel noise itself; no other unbiased estimate of the same corners scatters less.
  std::vector<Coefficients<double>> deviations;
  for (const Metric metric : kMetrics) {
    EstimatorOptions options;
    options.metric = metric;
    Fit<double> fit(fakes::flume_scene(12, 1), options);
    std::mt19937_64 random(2);
    fit.observe(kCornerNoise, &random);
    const auto found = fit.from_flat();
    deviations.push_back(found.standard_deviation / std::sqrt(found.variance_factor));
  }
  for (int j = 0; j < 12; ++j) {
    EXPECT_LE(deviations[0][j], 1.001 * deviations[1][j]);
    EXPECT_LE(deviations[0][j], 1.001 * deviations[2][j]);
  }
}

TEST(EstimatorCovariance, WithoutSpareResidualsTrustsTheSigmas) {
  Fit<double> fit(fakes::flume_scene(8, 1), {});
  fit.observe();
  const auto all = fit.seen[0];
  fit.seen[0] = {all[0], all[20], all[210], all[230]};
  for (auto& corner : fit.seen[0]) corner.sigma = 0.1;
  const auto found = fit.from_flat();
  ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
  EXPECT_EQ(found.variance_factor, 0);
  for (auto& corner : fit.seen[0]) corner.sigma = 0.2;
  const auto twice = fit.from_flat();
  EXPECT_NEAR(twice.standard_deviation[0] / found.standard_deviation[0], 2, 1e-6);
}

}  // namespace
}  // namespace srd::dsp
