// SPDX-License-Identifier: Apache-2.0
// Where the method's first program went wrong, and this one must not.
#include <gtest/gtest.h>

#include <limits>

#include "tests/dsp/estimator_fixture.hpp"

namespace srd::dsp {
namespace {

TEST(OpenSrdDefects, ThirdOrderModesComeBack) {
  for (const Metric metric : kMetrics)
    for (const int j : {8, 9}) {  // A30, A03
      fakes::Scene scene = fakes::flume_scene(12, 1);
      scene.truth = fakes::level(12, 80);
      scene.truth[j] = 0.5;
      EstimatorOptions options;
      options.metric = metric;
      Fit<double> fit(scene, options);
      const auto found = fit.from_flat();
      ASSERT_FALSE(failed(found.stop));
      EXPECT_NEAR(found.coefficients[j], 0.5, 1e-6) << scene.model.modes[j].name().data();
    }
}

TEST(OpenSrdDefects, LengthScalesAreTheModelsOwn) {
  fakes::Scene scene = fakes::flume_scene(12, 1);
  scene.model.lx = 310;
  scene.model.ly = 505;
  Fit<double> fit(scene, {});
  EXPECT_LE(scene.surface_error(fit.from_flat().coefficients), 1e-6);
}

TEST(OpenSrdDefects, NanIsNoPerfectFit) {
  for (const Metric metric : kMetrics) {
    EstimatorOptions options;
    options.metric = metric;
    Fit<double> fit(fakes::flume_scene(12, 1), options);
    fit.observe();
    for (auto& corner : fit.seen[0]) corner.pixel.setConstant(std::numeric_limits<double>::quiet_NaN());
    const auto found = fit.from_flat();
    EXPECT_TRUE(failed(found.stop));
    EXPECT_EQ(found.coefficients.size(), 0);
  }
}

TEST(OpenSrdDefects, CollinearityFromAPoorStartComesToTheRightDepth) {
  for (const int parameters : {1, 3, 5, 8, 12})
    for (const double start : {40.0, 70.0, 120.0}) {
      fakes::Scene scene = fakes::flume_scene(parameters, 1);
      scene.truth *= 0.2;
      scene.truth[0] = 5.6;
      EstimatorOptions options;
      options.metric = Metric::kCollinearity;
      Fit<double> exact(scene, options);
      const auto found = exact.from(fakes::level(parameters, start));
      ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
      EXPECT_NEAR(found.coefficients[0], 5.6, 1e-6);
      EXPECT_LE(scene.surface_error(found.coefficients), 1e-6);

      Fit<double> noisy(scene, options);
      std::mt19937_64 random(3);
      noisy.observe(0.1, &random);
      EXPECT_LE(scene.surface_error(noisy.from(fakes::level(parameters, start)).coefficients), 0.3);
    }
}

}  // namespace
}  // namespace srd::dsp
