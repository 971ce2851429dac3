// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/estimator/estimator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "tests/dsp/estimator_fixture.hpp"

namespace srd::dsp {
namespace {

// Metric, parameters, cameras.
class ExactFeatures : public testing::TestWithParam<std::tuple<Metric, int, int>> {
 protected:
  template <class S>
  void expect_surface(double limit_mm, double limit_px) {
    const auto [metric, parameters, cameras] = GetParam();
    EstimatorOptions options;
    options.metric = metric;
    Fit<S> fit(fakes::flume_scene(parameters, cameras), options);
    const Estimate<S> found = fit.from_flat();
    ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
    EXPECT_LE(fit.scene.surface_error(found.coefficients), limit_mm);
    EXPECT_LE(static_cast<double>(found.reprojection_rms), limit_px);
    EXPECT_EQ(found.corners_used, 231 * cameras);
    EXPECT_LE(found.iterations, 8);
    EXPECT_FALSE(found.at_bound);
    EXPECT_EQ(found.coefficients.size(), parameters);
    EXPECT_EQ(found.information.rows(), parameters);
  }
};

TEST_P(ExactFeatures, GiveTheSurfaceInDouble) { expect_surface<double>(1e-6, 1e-9); }
TEST_P(ExactFeatures, GiveTheSurfaceInFloat) { expect_surface<float>(1e-3, 1e-3); }

std::string exact_name(const testing::TestParamInfo<std::tuple<Metric, int, int>>& info) {
  static constexpr const char* kNames[] = {"Reprojection", "Disparity", "Collinearity"};
  return std::string(kNames[static_cast<int>(std::get<0>(info.param))]) + std::to_string(std::get<1>(info.param)) +
         "ParametersFrom" + std::to_string(std::get<2>(info.param)) + "Cameras";
}

INSTANTIATE_TEST_SUITE_P(Estimator, ExactFeatures,
                         testing::Combine(testing::ValuesIn(kMetrics), testing::Values(1, 3, 5, 8, 12),
                                          testing::Values(1, 2, 3)),
                         exact_name);

TEST(Estimator, FitsTwentyFourFreelyChosenModes) {
  std::vector<Mode> modes;
  for (const char* name : {"A00", "B",   "C",   "A10", "A01", "A20", "A02", "A11", "A12", "A21", "A22", "A03",
                           "A13", "A23", "A04", "A14", "A24", "A05", "A15", "A25", "A06", "A16", "A31", "A32"})
    modes.push_back(*Mode::parse(name));
  for (const Metric metric : kMetrics) {
    fakes::Scene scene = fakes::flume_scene(1, 2);
    scene.model.modes = ModeList::make(modes).value();
    scene.truth = fakes::wavy(24);
    EstimatorOptions options;
    options.metric = metric;
    Fit<double> wide(scene, options);
    const auto found = wide.from_flat();
    ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
    EXPECT_LE(scene.surface_error(found.coefficients), 1e-6);
    Fit<float> narrow(scene, options);
    const auto found_float = narrow.from_flat();
    ASSERT_FALSE(failed(found_float.stop)) << to_string(found_float.stop);
    EXPECT_LE(scene.surface_error(found_float.coefficients), 1e-3);
  }
}

TEST(Estimator, FitsAnyListOfModes) {
  std::vector<Mode> all{{Mode::Kind::kSlopeX, 0, 0}, {Mode::Kind::kSlopeY, 0, 0}};
  for (std::uint8_t m = 0; m <= kMaxHarmonic; ++m)
    for (std::uint8_t n = 0; n <= kMaxHarmonic; ++n)
      if (m + n > 0) all.push_back({Mode::Kind::kCosine, m, n});
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> one(-1, 1);
  for (int draw = 0; draw < 12; ++draw) {
    // Two of each size but most of the largest, in any order.
    const std::size_t count = draw < 6 ? kMaxModes : static_cast<std::size_t>(4 * (draw - 5));
    std::shuffle(all.begin(), all.end(), random);
    std::vector<Mode> modes(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count - 1));
    modes.insert(modes.begin() + static_cast<std::ptrdiff_t>(count / 2), Mode{});
    fakes::Scene scene = fakes::flume_scene(1, 2);
    scene.model.modes = ModeList::make(modes).value();
    scene.truth = Coefficients<double>::Zero(static_cast<Eigen::Index>(count));
    Coefficients<double> start = scene.truth;
    for (std::size_t j = 0; j < count; ++j) {
      const int harmonics = modes[j].m + modes[j].n;
      scene.truth[static_cast<Eigen::Index>(j)] = one(random) / (1 + harmonics * harmonics / 8.0);
    }
    scene.truth[scene.model.modes.index_of(Mode{})] = 80;
    start[scene.model.modes.index_of(Mode{})] = 84;
    Fit<double> wide(scene, {});
    const auto found = wide.from(start);
    ASSERT_FALSE(failed(found.stop)) << to_string(found.stop) << " " << draw;
    EXPECT_EQ(found.rank.rank, static_cast<int>(count));
    EXPECT_LE(scene.surface_error(found.coefficients), 1e-6) << draw;
    Fit<float> narrow(scene, {});
    const auto found_float = narrow.from(start);
    ASSERT_FALSE(failed(found_float.stop)) << to_string(found_float.stop) << " " << draw;
    EXPECT_LE(scene.surface_error(found_float.coefficients), 1e-3) << draw;
  }
}

TEST(Estimator, FitsAModelWithoutAConstantAndWithAnOrigin) {
  fakes::Scene scene = fakes::flume_scene(1, 1);
  scene.model.modes = ModeList::make(std::vector<Mode>{*Mode::parse("B"), *Mode::parse("A10")}).value();
  scene.model.x0 = -300;  // the slope alone makes 60 to 100 mm
  scene.truth = fakes::coefficients({48, 2});
  Fit<double> fit(scene, {});
  const auto found = fit.from(fakes::coefficients({40, 0}));
  ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
  EXPECT_LE(scene.surface_error(found.coefficients), 1e-6);
}

TEST(Estimator, SeesThroughPlatesOnTheFloor) {
  for (const Metric metric : kMetrics) {
    fakes::Scene scene = fakes::flume_scene(8, 1);
    scene.media.layers[0] = {6, 1.52};
    scene.media.layers[1] = {10, 1.49};
    scene.media.n_layers = 2;
    EstimatorOptions options;
    options.metric = metric;
    Fit<double> fit(scene, options);
    const auto found = fit.from_flat();
    ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
    EXPECT_LE(scene.surface_error(found.coefficients), 1e-6);
    // Taking the plates for water shows: the test would not pass without tracing them.
    fit.scene.media.n_layers = 0;
    const auto ignored = fit.from_flat();
    EXPECT_GT(scene.surface_error(ignored.coefficients), 0.1);
  }
}

TEST(Estimator, WeightsCornersByTheirSigma) {
  // Half the corners are 2 px off, and say so.
  Fit<double> fit(fakes::flume_scene(5, 1), {});
  fit.observe();
  for (std::size_t i = 0; i < fit.seen[0].size(); i += 2) {
    auto& corner = fit.seen[0][i];
    corner.pixel.x() += 2;
    corner.sigma = 2000;
    corner.normalised = fit.views[0].camera.undistort(corner.pixel).value();
  }
  EXPECT_LT(fit.scene.surface_error(fit.from_flat().coefficients), 1e-3);
  for (auto& corner : fit.seen[0]) corner.sigma = 1;
  EXPECT_GT(fit.scene.surface_error(fit.from_flat().coefficients), 0.1);
}

TEST(Estimator, TakesTheStartThatCostsLeast) {
  for (const Metric metric : kMetrics) {
    EstimatorOptions options;
    options.metric = metric;
    Fit<double> fit(fakes::flume_scene(5, 1), options);
    fit.observe();
    const auto cameras = fit.cameras();
    auto estimator = fit.estimator();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Coefficients<double>> starts{fakes::level(5, 90), fakes::level(5, -40), fakes::level(5, nan),
                                                   fakes::wavy(5, 80.5), fakes::level(5, 70)};
    const auto found = estimator.estimate(cameras, starts);
    ASSERT_FALSE(failed(found.stop));
    EXPECT_EQ(found.start_used, 3);
    EXPECT_LE(fit.scene.surface_error(found.coefficients), 1e-6);
  }
}

TEST(Estimator, GivesTheSameAnswerEachTime) {
  Fit<float> fit(fakes::flume_scene(12, 2), {});
  std::mt19937_64 random(5);
  fit.observe(0.1, &random);
  const Coefficients<float> start = fakes::level(12, 84).cast<float>();
  auto estimator = fit.estimator();
  const auto cameras = fit.cameras();
  const auto first = estimator.estimate(cameras, std::span(&start, 1));
  const auto second = estimator.estimate(cameras, std::span(&start, 1));
  EXPECT_EQ(first.iterations, second.iterations);
  EXPECT_EQ((first.coefficients - second.coefficients).norm(), 0);
}

TEST(Estimator, ReportsErrorsInTheMetricsUnit) {
  // A pixel beside the truth moves the bottom point by some 0.45 mm and needs the normal turned by some 20 mrad.
  std::vector<double> errors;
  for (const Metric metric : kMetrics) {
    EstimatorOptions options;
    options.metric = metric;
    Fit<double> fit(fakes::flume_scene(5, 1), options);
    std::mt19937_64 random(7);
    fit.observe(0.5, &random);
    const auto found = fit.from_flat();
    ASSERT_FALSE(failed(found.stop));
    errors.push_back(found.mean_error);
    // Per axis, nearly the noise; the fit takes 5 of 462 degrees of freedom.
    EXPECT_NEAR(found.reprojection_rms, 0.5, 0.05) << static_cast<int>(metric);
    EXPECT_NEAR(found.variance_factor, 1, 0.2) << static_cast<int>(metric);
  }
  EXPECT_NEAR(errors[0], 0.5 * 1.2533, 0.06);  // mean of a Rayleigh distribution
  EXPECT_NEAR(errors[1] / errors[0], 0.45, 0.1);
  EXPECT_NEAR(errors[2] / errors[0], 0.022, 0.008);
}

TEST(Estimator, MakeRefusesWhatMakesNoSense) {
  const fakes::Scene scene = fakes::flume_scene(3, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto made = [&](auto change) {
    auto model = scene.model;
    auto media = scene.media;
    auto points = scene.points;
    EstimatorOptions options;
    int corners = 100;
    change(model, media, points, options, corners);
    return SurfaceEstimator<double>::make(model, media, points, options, corners).ok();
  };
  EXPECT_TRUE(made([](auto&, auto&, auto&, auto&, auto&) {}));
  EXPECT_FALSE(made([](auto& model, auto&, auto&, auto&, auto&) { model.modes = {}; }));
  EXPECT_FALSE(made([](auto& model, auto&, auto&, auto&, auto&) { model.lx = 0; }));
  EXPECT_FALSE(made([&](auto& model, auto&, auto&, auto&, auto&) { model.y0 = nan; }));
  EXPECT_FALSE(made([](auto&, auto& media, auto&, auto&, auto&) { media.water = -1.3; }));
  EXPECT_FALSE(made([](auto&, auto& media, auto&, auto&, auto&) { media.n_layers = kMaxLayers + 1; }));
  EXPECT_FALSE(made([](auto&, auto& media, auto&, auto&, auto&) {
    media.n_layers = 1;
    media.layers[0].thickness = -1;
  }));
  EXPECT_FALSE(made([](auto&, auto&, auto& points, auto&, auto&) { points.clear(); }));
  EXPECT_FALSE(made([&](auto&, auto&, auto& points, auto&, auto&) { points[4].z() = nan; }));
  EXPECT_FALSE(made([](auto&, auto&, auto&, auto& options, auto&) { options.scale = {1, 1}; }));
  EXPECT_FALSE(made([](auto&, auto&, auto&, auto& options, auto&) { options.scale = {1, 0, 1}; }));
  EXPECT_FALSE(made([](auto&, auto&, auto&, auto& options, auto&) {
    options.lower = {0, 0, 0};
    options.upper = {1, -1, 1};
  }));
  EXPECT_FALSE(made([](auto&, auto&, auto&, auto& options, auto&) { options.epsf = -1; }));
  EXPECT_FALSE(made([](auto&, auto&, auto&, auto& options, auto&) { options.max_iterations = -1; }));
  EXPECT_FALSE(made([](auto&, auto&, auto&, auto&, auto& corners) { corners = 0; }));
}

}  // namespace
}  // namespace srd::dsp
