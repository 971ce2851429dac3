// SPDX-License-Identifier: Apache-2.0
// The index of water as one more unknown.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

#include "dsp/estimate/residual/ray_residual.hpp"
#include "dsp/estimate/residual/reprojection_residual.hpp"
#include "tests/dsp/estimator_fixture.hpp"

namespace srd::dsp {
namespace {

EstimatorOptions with_free_index(Metric metric = Metric::kReprojection) {
  EstimatorOptions options;
  options.metric = metric;
  options.free_index = true;
  return options;
}

// Cameras at the given angles from the vertical, round the flume; water of index 1.333 that the estimator takes for
// 1.340 at first.
struct IndexScene {
  fakes::Scene truth;
  Fit<double> fit;
  static constexpr double kTrue = 1.333;

  static fakes::Scene with_index(fakes::Scene scene, double index) {
    scene.media.water = index;
    return scene;
  }
  IndexScene(fakes::Scene scene, const EstimatorOptions& options, double noise = 0, std::uint64_t seed = 1)
      : truth(with_index(scene, kTrue)), fit(with_index(scene, 1.340), options) {
    std::mt19937_64 random(seed);
    for (std::size_t i = 0; i < truth.views.size(); ++i)
      fit.seen.push_back(truth.observe<double>(i, noise, noise > 0 ? &random : nullptr));
  }
};

fakes::Scene vertical_scene(int parameters) {
  fakes::Scene scene = fakes::flume_scene(parameters, 1);
  scene.views[0] = fakes::look_at(fakes::flume_camera(), {100, 200, 950}, {100, 200, 0});
  scene.truth = fakes::level(parameters, 80);
  return scene;
}

TEST(FreeIndex, DerivativeOfTheOffsetIsThatOfCentralDifferences) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> one(-1, 1);
  for (int draw = 0; draw < 200; ++draw) {
    const Vec3<double> d = Vec3<double>(0.6 * one(random), 0.6 * one(random), -1).normalized();
    const double zx = 0.3 * one(random), zy = 0.3 * one(random), height = 160 + 120 * one(random);
    Media<double> media;
    media.n_layers = draw % 3;
    media.layers[0] = {8, 1.52};
    media.layers[1] = {12, 1.49};
    Crossing<double> at, above, below;
    ASSERT_TRUE(cross(d, zx, zy, height, media, true, at, true));
    const double h = 1e-5;
    Media<double> more = media, less = media;
    more.water += h;
    less.water -= h;
    ASSERT_TRUE(cross(d, zx, zy, height, more, false, above));
    ASSERT_TRUE(cross(d, zx, zy, height, less, false, below));
    const Vec2<double> expected = (above.offset - below.offset) / (2 * h);
    EXPECT_LT((at.by_index - expected).norm(), 1e-7 * (1 + expected.norm())) << draw;
  }
}

TEST(FreeIndex, DerivativesOfTheResidualsAreThoseOfCentralDifferences) {
  for (const Metric metric : kMetrics)
    for (const int plates : {0, 2}) {
      fakes::Scene scene = fakes::flume_scene(8, 1);
      scene.media.layers[0] = {8, 1.52};
      scene.media.layers[1] = {12, 1.49};
      scene.media.n_layers = plates;
      std::mt19937_64 random(9);
      const auto seen = scene.observe<double>(0, 0.3, &random);
      const Coefficients<double> a = fakes::wavy(8, 78);
      for (std::size_t i = 0; i < seen.size(); i += 23) {
        PreparedCorner<double> corner;
        const WideView wide(scene.views[0]);
        ASSERT_TRUE(prepare(seen[i], scene.points[i], wide, corner));
        ASSERT_TRUE(prepare_ray(seen[i], wide, true, corner));
        corner.view = &scene.views[0];
        const auto at = [&](double index, Basis<double>* basis) {
          Media<double> media = scene.media;
          media.water = index;
          Optics<double> optics = Optics<double>::make(scene.model, media);
          optics.free_index = true;
          start_at_level(78.0, true, corner);
          CornerResidual<double> out;
          const bool valid = metric == Metric::kReprojection ? reprojection_residual(optics, a, corner, basis, out)
                                                             : ray_residual(metric, optics, a, corner, basis, out);
          EXPECT_TRUE(valid);
          return out;
        };
        Basis<double> basis;
        const double h = 1e-4;
        const Vec2<double> by_index = at(1.333, &basis).by_index;
        const Vec2<double> expected = (at(1.333 + h, nullptr).e - at(1.333 - h, nullptr).e) / (2 * h);
        EXPECT_LT((by_index - expected).norm(), 2e-6 * expected.norm() + 1e-9) << static_cast<int>(metric);
      }
    }
}

// Parameters, cameras.
class FreeIndexExact : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(FreeIndexExact, GivesTheIndexAndTheSurface) {
  const auto [parameters, cameras] = GetParam();
  for (const Metric metric : kMetrics) {
    IndexScene scene(fakes::flume_scene(parameters, cameras), with_free_index(metric));
    const auto found = scene.fit.from_flat();
    ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
    EXPECT_NEAR(found.index, IndexScene::kTrue, 1e-6);
    EXPECT_LE(scene.truth.surface_error(found.coefficients), 1e-5);
    EXPECT_EQ(found.coefficients.size(), parameters);
    EXPECT_EQ(found.information.rows(), parameters);
    EXPECT_EQ(found.standard_deviation.size(), parameters);
    EXPECT_EQ(found.rank.rank, parameters + 1);
    EXPECT_FALSE(found.at_bound);
  }
}

INSTANTIATE_TEST_SUITE_P(Estimator, FreeIndexExact, testing::Combine(testing::Values(3, 5, 8, 12), testing::Values(2, 3)));

TEST(FreeIndex, IsFoundBesideTwentyFourModesAndUnderPlates) {
  std::vector<Mode> modes;
  for (int m = 0; m < 5; ++m)
    for (int n = 0; n < 5; ++n)
      if (m + n < 8) modes.push_back({Mode::Kind::kCosine, static_cast<std::uint8_t>(m), static_cast<std::uint8_t>(n)});
  fakes::Scene scene = fakes::flume_scene(1, 3);
  scene.model.modes = ModeList::make(modes).value();
  ASSERT_EQ(scene.model.modes.size(), 24);
  scene.truth = fakes::wavy(24);
  scene.media.layers[0] = {8, 1.52};
  scene.media.n_layers = 1;
  IndexScene wide(scene, with_free_index());
  const auto found = wide.fit.from_flat();
  ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
  EXPECT_NEAR(found.index, IndexScene::kTrue, 1e-6);
  EXPECT_LE(wide.truth.surface_error(found.coefficients), 1e-5);
}

TEST(FreeIndex, ScattersAsItsStatedDeviationSays) {
  constexpr int kIndexDraws = 400;
  double squares = 0, variances = 0, nees = 0;
  for (int draw = 0; draw < kIndexDraws; ++draw) {
    IndexScene scene(fakes::flume_scene(5, 3), with_free_index(), 0.1, static_cast<std::uint64_t>(draw));
    const auto found = scene.fit.from_flat();
    ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
    const double error = found.index - IndexScene::kTrue;
    squares += error * error / kIndexDraws;
    variances += found.index_deviation * found.index_deviation / kIndexDraws;
    const Coefficients<double> off = found.coefficients - scene.truth.truth;
    nees += off.dot(found.information * off) / kIndexDraws;
  }
  EXPECT_NEAR(squares / variances, 1, 4.5 * std::sqrt(2.0 / kIndexDraws));
  // Of the coefficients alone, whatever the index.
  EXPECT_NEAR(nees, 5, 4.5 * std::sqrt(10.0 / kIndexDraws));
}

TEST(FreeIndex, IsRefusedFromAboveOverFlatWaterWithTheReason) {
  for (const double noise : {0.0, 0.1})
    for (const int parameters : {1, 3, 5, 8}) {
      IndexScene scene(vertical_scene(parameters), with_free_index(), noise);
      const auto found = scene.fit.from_flat();
      EXPECT_EQ(found.stop, Stop::kIndexUndetermined) << to_string(found.stop);
      EXPECT_TRUE(failed(found.stop));
      ASSERT_GT(found.rank.n_dependences, 0);
      const Dependence& index = found.rank.dependences[static_cast<std::size_t>(found.rank.n_dependences - 1)];
      EXPECT_EQ(index.parameter, parameters);
      ASSERT_GT(index.n_others, 0);
      EXPECT_EQ(index.others[0], 0) << "the level";
      // The same view gives the surface when the index is given.
      scene.fit.options.free_index = false;
      EXPECT_FALSE(failed(scene.fit.from_flat().stop));
    }
}

TEST(FreeIndex, IsRefusedWhereItsDeviationIsTooLarge) {
  EstimatorOptions options = with_free_index();
  options.index_most_deviation = 0.0005;
  IndexScene noisy(fakes::flume_scene(5, 3), options, 0.1);
  const auto refused = noisy.fit.from_flat();
  EXPECT_EQ(refused.stop, Stop::kIndexUndetermined);
  EXPECT_GT(refused.index_deviation, 0.0005);
  ASSERT_EQ(refused.rank.n_dependences, 1);
  EXPECT_EQ(refused.rank.dependences[0].parameter, 5);
  IndexScene precise(fakes::flume_scene(5, 3), options, 0.01);
  EXPECT_FALSE(failed(precise.fit.from_flat().stop));
}

TEST(FreeIndex, StaysWithinItsBoundsAndSaysSo) {
  EstimatorOptions options = with_free_index();
  options.index_lower = 1.335;
  IndexScene scene(fakes::flume_scene(8, 3), options, 0.01);
  const auto found = scene.fit.from_flat();
  EXPECT_TRUE(found.at_bound);
  EXPECT_EQ(found.index, 1.335);
}

TEST(FreeIndex, LeavesTheIndexAloneWhenItIsGiven) {
  Fit<double> fit(fakes::flume_scene(5, 2), {});
  const auto found = fit.from_flat();
  EXPECT_EQ(found.index, fit.scene.media.water);
  EXPECT_EQ(found.index_deviation, 0);
}

TEST(FreeIndex, TheNextFitStartsFromTheIndexFound) {
  IndexScene scene(fakes::flume_scene(8, 3), with_free_index());
  auto estimator = scene.fit.estimator();
  const Coefficients<double> start = fakes::level(8, 84);
  const auto cameras = scene.fit.cameras();
  EXPECT_EQ(estimator.media().water, 1.340);
  const auto found = estimator.estimate(cameras, std::span(&start, 1));
  EXPECT_EQ(estimator.media().water, found.index);
}

TEST(FreeIndex, MakeRefusesBoundsThatMakeNoSense) {
  const fakes::Scene scene = fakes::flume_scene(3, 1);
  const auto made = [&](double lower, double upper, double deviation) {
    EstimatorOptions options = with_free_index();
    options.index_lower = lower;
    options.index_upper = upper;
    options.index_most_deviation = deviation;
    return SurfaceEstimator<double>::make(scene.model, scene.media, scene.points, options, 300).ok();
  };
  EXPECT_TRUE(made(1.3, 1.4, 0.005));
  EXPECT_FALSE(made(1.4, 1.3, 0.005));
  EXPECT_FALSE(made(std::nan(""), 1.4, 0.005));
  EXPECT_FALSE(made(1.3, std::nan(""), 0.005));
  EXPECT_FALSE(made(1.3, 1.4, 0));
}

}  // namespace
}  // namespace srd::dsp
