// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/solver/damped_gauss_newton.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

using Vector = Coefficients<double>;

// Residuals and their rows of the Jacobian, as a test writes them.
struct Residuals {
  std::function<bool(const Vector&, std::vector<double>&, std::vector<Vector>&)> rows;
  int evaluations = 0;

  bool evaluate(const Vector& a, NormalEquations& sums) {
    ++evaluations;
    std::vector<double> e;
    std::vector<Vector> j;
    if (!rows(a, e, j)) return false;
    sums.reset(static_cast<int>(a.size()));
    for (std::size_t i = 0; i < e.size(); ++i) {
      sums.cost += e[i] * e[i];
      for (Eigen::Index c = 0; c < a.size(); ++c) {
        sums.jte[c] += j[i][c] * e[i];
        for (Eigen::Index r = 0; r <= c; ++r) sums.jtj(r, c) += j[i][r] * j[i][c];
      }
    }
    sums.cost_noise = 1e-15 * sums.cost;
    return true;
  }
};

Residuals rosenbrock() {
  return {[](const Vector& a, std::vector<double>& e, std::vector<Vector>& j) {
    e = {10 * (a[1] - a[0] * a[0]), 1 - a[0]};
    j = {fakes::coefficients({-20 * a[0], 10}), fakes::coefficients({-1, 0})};
    return true;
  }};
}

GaussNewtonOptions tight() {
  GaussNewtonOptions options;
  options.epsg = options.epsx = 1e-12;
  options.max_iterations = 200;
  return options;
}

template <class Problem>
GaussNewtonSummary solve(Problem& problem, const GaussNewtonOptions& options, Vector& a) {
  NormalEquations sums;
  return DampedGaussNewton<Problem>(problem, options).minimise(a, sums);
}

TEST(DampedGaussNewton, FindsTheBottomOfACurvedValley) {
  for (const double x : {-1.2, 3.0, -20.0}) {
    Residuals problem = rosenbrock();
    Vector a = fakes::coefficients({x, 1});
    const auto summary = solve(problem, tight(), a);
    EXPECT_FALSE(failed(summary.stop)) << to_string(summary.stop);
    EXPECT_NEAR(a[0], 1, 1e-9);
    EXPECT_NEAR(a[1], 1, 1e-9);
  }
}

TEST(DampedGaussNewton, CountsItsTrialPoints) {
  Residuals problem = rosenbrock();
  Vector a = fakes::coefficients({-1.2, 1});
  const auto summary = solve(problem, tight(), a);
  EXPECT_EQ(problem.evaluations, summary.iterations + 1);
}

TEST(DampedGaussNewton, StaysInTheBoxAndFindsItsBest) {
  Residuals problem = rosenbrock();
  GaussNewtonOptions options = tight();
  options.lower = fakes::coefficients({-2, -2});
  options.upper = fakes::coefficients({0.5, 2});
  Vector a = fakes::coefficients({-1.2, 1});
  const auto summary = solve(problem, options, a);
  EXPECT_FALSE(failed(summary.stop));
  EXPECT_TRUE(summary.at_bound);
  EXPECT_EQ(a[0], 0.5);
  EXPECT_NEAR(a[1], 0.25, 1e-9);
}

TEST(DampedGaussNewton, LeavesABoundThatNoLongerHolds) {
  Residuals problem = rosenbrock();
  GaussNewtonOptions options = tight();
  options.lower = fakes::coefficients({-2, -0.1});
  options.upper = fakes::coefficients({2, 2});
  Vector a = fakes::coefficients({0.0, -0.1});  // held at first: the valley lies higher
  const auto summary = solve(problem, options, a);
  EXPECT_FALSE(summary.at_bound);
  EXPECT_NEAR(a[1], 1, 1e-9);
}

TEST(DampedGaussNewton, RefusesStepsOutOfTheDomainAndGoesOn) {
  // log(a) = 0: from 5 the full step lands at -3, where there is no residual.
  int outside = 0;
  Residuals problem{[&](const Vector& a, std::vector<double>& e, std::vector<Vector>& j) {
    if (!(a[0] > 0)) {
      ++outside;
      return false;
    }
    e = {std::log(a[0])};
    j = {fakes::coefficients({1 / a[0]})};
    return true;
  }};
  Vector a = fakes::coefficients({5});
  const auto summary = solve(problem, tight(), a);
  EXPECT_FALSE(failed(summary.stop));
  EXPECT_NEAR(a[0], 1, 1e-9);
  EXPECT_GT(outside, 0);
}

TEST(DampedGaussNewton, RefusesStepsToNan) {
  int broken = 0;
  Residuals problem{[&](const Vector& a, std::vector<double>& e, std::vector<Vector>& j) {
    e = {a[0] > 0 ? std::log(a[0]) : std::numeric_limits<double>::quiet_NaN()};
    if (!(a[0] > 0)) ++broken;
    j = {fakes::coefficients({1 / a[0]})};
    return true;
  }};
  Vector a = fakes::coefficients({5});
  const auto summary = solve(problem, tight(), a);
  EXPECT_FALSE(failed(summary.stop));
  EXPECT_NEAR(a[0], 1, 1e-9);
  EXPECT_GT(broken, 0);
}

TEST(DampedGaussNewton, FailsWhereTheStartIsNan) {
  Residuals problem{[](const Vector& a, std::vector<double>& e, std::vector<Vector>& j) {
    e = {std::numeric_limits<double>::quiet_NaN()};
    j = {fakes::coefficients({a[0]})};
    return true;
  }};
  Vector a = fakes::coefficients({5});
  EXPECT_EQ(solve(problem, tight(), a).stop, Stop::kNonFinite);
  Vector nan = fakes::coefficients({std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(solve(problem, tight(), nan).stop, Stop::kNonFinite);
}

TEST(DampedGaussNewton, FailsWhereTheStartIsOutside) {
  Residuals problem{[](const Vector&, std::vector<double>&, std::vector<Vector>&) { return false; }};
  Vector a = fakes::coefficients({5});
  EXPECT_EQ(solve(problem, tight(), a).stop, Stop::kOutOfDomain);
}

TEST(DampedGaussNewton, GivesUpWhenNoStepIsAllowed) {
  bool first = true;
  Residuals problem{[&](const Vector& a, std::vector<double>& e, std::vector<Vector>& j) {
    e = {a[0]};
    j = {fakes::coefficients({1})};
    return std::exchange(first, false);
  }};
  Vector a = fakes::coefficients({5});
  GaussNewtonOptions options = tight();
  options.max_iterations = 1000;
  const auto summary = solve(problem, options, a);
  EXPECT_EQ(summary.stop, Stop::kNoProgress);
  EXPECT_EQ(a[0], 5);
}

TEST(ScaledCholesky, TellsDependentColumnsFromBadlyScaledOnes) {
  InformationMatrix<double> a(2, 2);
  a << 1e12, 1, 1, 1e-8;  // correlation 0.01
  ScaledCholesky factors;
  ASSERT_TRUE(factors.factor(a));
  EXPECT_NEAR(factors.smallest_pivot(), 1 - 1e-4, 1e-12);
  EXPECT_LT((factors.inverse().lazyProduct(a) - InformationMatrix<double>::Identity(2, 2)).norm(), 1e-9);
  a << 4, 2, 2, 1;
  ASSERT_TRUE(factors.factor(a));
  EXPECT_LT(std::abs(factors.smallest_pivot()), 1e-15);
  a << 4, 0, 0, 0;
  EXPECT_FALSE(factors.factor(a));
}

}  // namespace
}  // namespace srd::dsp
