// SPDX-License-Identifier: Apache-2.0
// The estimator against the bound of optics (19): 4000 draws of corner noise for each size of model and number of cameras.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <tuple>
#include <vector>

#include "dsp/estimate/solver/cholesky.hpp"
#include "tests/dsp/estimator_fixture.hpp"

namespace srd::dsp {
namespace {

constexpr int kBoundDraws = 4000;

// (sum J'J / sigma^2)^-1 with J by central differences of the simulated pixels: nothing of the estimator's own.
InformationMatrix<double> bound_covariance(const fakes::Scene& scene) {
  constexpr double kStep = 1e-3;  // mm
  const int n = scene.parameters();
  InformationMatrix<double> information = InformationMatrix<double>::Zero(n, n);
  fakes::Scene moved = scene;
  for (std::size_t view = 0; view < scene.views.size(); ++view)
    for (const Vec3<double>& point : scene.points) {
      Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxParameters> j(2, n);
      for (int k = 0; k < n; ++k) {
        moved.truth = scene.truth;
        moved.truth[k] += kStep;
        const Vec2<double> above = scene.views[view].camera.pixel(moved.seen(view, point));
        moved.truth[k] -= 2 * kStep;
        j.col(k) = (above - scene.views[view].camera.pixel(moved.seen(view, point))) / (2 * kStep * kCornerNoise);
      }
      information += j.transpose().lazyProduct(j);
    }
  ScaledCholesky factors;
  EXPECT_TRUE(factors.factor(information));
  return factors.inverse();
}

// Mean over the pattern of the squared height that coefficients make: a'Ga.
InformationMatrix<double> surface_gram(const fakes::Scene& scene) {
  InformationMatrix<double> gram = InformationMatrix<double>::Zero(scene.parameters(), scene.parameters());
  for (const Vec3<double>& point : scene.points) {
    Basis<double> basis;
    scene.model.basis(point.x(), point.y(), basis);
    gram += basis.value.lazyProduct(basis.value.transpose()) / static_cast<double>(scene.points.size());
  }
  return gram;
}

// Parameters, cameras.
class SlowBound : public testing::TestWithParam<std::tuple<int, int>> {
 protected:
  template <class S>
  void compare() {
    const auto [parameters, cameras] = GetParam();
    Fit<S> fit(fakes::flume_scene(parameters, cameras), {});
    fit.observe();
    const auto exact = fit.seen;
    for (auto& view : fit.seen)
      for (Observation<S>& corner : view) corner.sigma = static_cast<S>(kCornerNoise);
    auto estimator = fit.estimator();
    const Coefficients<S> start = fit.scene.truth.template cast<S>();
    const InformationMatrix<double> gram = surface_gram(fit.scene), bound = bound_covariance(fit.scene);
    const auto seen = fit.cameras();
    std::mt19937_64 random(static_cast<std::uint64_t>(1000 + 10 * parameters + cameras));
    std::normal_distribution<double> normal(0, kCornerNoise);
    Coefficients<double> sum = Coefficients<double>::Zero(parameters), squares = sum, variances = sum;
    double surface = 0, nees = 0;
    for (int draw = 0; draw < kBoundDraws; ++draw) {
      // Reprojection takes the undistorted corner for nothing but a start.
      for (std::size_t view = 0; view < exact.size(); ++view)
        for (std::size_t i = 0; i < exact[view].size(); ++i)
          for (int axis = 0; axis < 2; ++axis)
            fit.seen[view][i].pixel[axis] = exact[view][i].pixel[axis] + static_cast<S>(normal(random));
      const auto found = estimator.estimate(seen, std::span(&start, 1));
      ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
      const Coefficients<double> error = found.coefficients.template cast<double>() - fit.scene.truth;
      sum += error;
      squares += error.cwiseAbs2();
      variances += found.standard_deviation.template cast<double>().cwiseAbs2();
      surface += error.dot(gram * error) / kBoundDraws;
      nees += error.dot(found.information.template cast<double>() * error) / kBoundDraws;
    }
    const double at_bound = std::sqrt(gram.cwiseProduct(bound).sum());
    const double of_bound = std::sqrt(surface) / at_bound;
    EXPECT_NEAR(of_bound, 1, 0.05);
    double least = 1e9, most = 0;
    for (int j = 0; j < parameters; ++j) {
      const double mean = sum[j] / kBoundDraws;
      const double ratio = std::sqrt((squares[j] / kBoundDraws - mean * mean) / (variances[j] / kBoundDraws));
      EXPECT_NEAR(ratio, 1, 0.05) << "coefficient " << j;
      least = std::min(least, ratio);
      most = std::max(most, ratio);
      // No bias that 4000 draws can show.
      EXPECT_LT(std::abs(mean), 4.5 * std::sqrt(variances[j]) / kBoundDraws) << "coefficient " << j;
    }
    // p times an F distribution with p and the spare residuals' degrees of freedom; 3.29 deviations hold 99.9 %.
    const double p = parameters, spare = 462.0 * cameras - p;
    const double expected = p * spare / (spare - 2);
    const double deviation =
        p * std::sqrt(2 * spare * spare * (p + spare - 2) / (p * (spare - 2) * (spare - 2) * (spare - 4)) / kBoundDraws);
    EXPECT_NEAR(nees, expected, 3.29 * deviation);
    std::printf(
        "%2d parameters, %d cameras, %s: surface %.5f mm rms, %.4f of the bound; scatter/stated %.3f to %.3f; "
        "nees %.3f, expected %.3f +- %.3f\n",
        parameters, cameras, sizeof(S) == sizeof(float) ? "float" : "double", std::sqrt(surface), of_bound, least, most, nees,
        expected, 3.29 * deviation);
  }
};

TEST_P(SlowBound, IsReachedAndTheStatedDeviationsAreTrue) {
  if (std::get<1>(GetParam()) == 1)
    compare<double>();
  else
    compare<float>();
}

INSTANTIATE_TEST_SUITE_P(SlowEstimator, SlowBound, testing::Combine(testing::Values(5, 8, 12), testing::Values(1, 2, 3)));

}  // namespace
}  // namespace srd::dsp
