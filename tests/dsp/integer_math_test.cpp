#include "dsp/core/integer_math.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "dsp/frontend/edge_profile.hpp"

namespace srd::dsp {
namespace {

TEST(IntegerMath, SquareRootIsTheFloor) {
  std::mt19937_64 random(7);
  for (int k = 0; k < 20000; ++k) {
    const std::uint64_t x = random() >> (random() % 64);
    const std::uint64_t root = isqrt(x);
    ASSERT_LE(root * root, x);
    ASSERT_TRUE(root == 0xffffffffu || (root + 1) * (root + 1) > x) << x;
  }
  EXPECT_EQ(isqrt(0), 0u);
  EXPECT_EQ(isqrt(~std::uint64_t{0}), 0xffffffffu);
}

TEST(IntegerMath, DivisionRoundsHalvesAwayFromZero) {
  EXPECT_EQ(divide_rounded(5, 2), 3);
  EXPECT_EQ(divide_rounded(-5, 2), -3);
  EXPECT_EQ(divide_rounded(4, 3), 1);
  EXPECT_EQ(divide_rounded(-4, 3), -1);
}

TEST(FixedCholesky, SolvesAsDoublePrecisionDoes) {
  using Matrix7 = Eigen::Matrix<double, 7, 7>;
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> entry(-1, 1);
  for (int k = 0; k < 500; ++k) {
    Matrix7 m;
    for (int i = 0; i < 49; ++i) m(i) = entry(random);
    const Matrix7 spd = ((m * m.transpose() + 0.1 * Matrix7::Identity()) * 1e9).array().round().matrix();
    Vector7 y;
    for (int i = 0; i < 7; ++i) y(i) = std::round(entry(random) * 1e9);
    std::array<std::array<std::int64_t, 7>, 7> a;
    std::array<std::int64_t, 7> right, x;
    for (std::size_t i = 0; i < 7; ++i) {
      right[i] = std::llround(y(static_cast<int>(i)));
      for (std::size_t j = 0; j < 7; ++j) a[i][j] = std::llround(spd(static_cast<int>(i), static_cast<int>(j)));
    }
    FixedCholesky<7> solver;
    ASSERT_TRUE(solver.factor(a));
    solver.solve(right, 20, x);
    const Vector7 truth = spd.llt().solve(y);
    // Rounding to 2^-30 in correlation form, grown by its condition number.
    const Vector7 scale = spd.diagonal().array().sqrt().inverse().matrix();
    const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(scale.asDiagonal() * spd * scale.asDiagonal());
    const double condition = eigen.eigenvalues()(6) / eigen.eigenvalues()(0);
    for (std::size_t i = 0; i < 7; ++i)
      ASSERT_NEAR(std::ldexp(static_cast<double>(x[i]), -20), truth(static_cast<int>(i)), 1e-6 + 16 * std::ldexp(1.0, -30) * condition * truth.norm());
  }
}

TEST(FixedCholesky, RefusesWhatIsNotPositiveDefinite) {
  FixedCholesky<2> solver;
  EXPECT_FALSE(solver.factor({{{1000000, 1000000}, {0, 1000000}}}));
  EXPECT_FALSE(solver.factor({{{1000000, 0}, {0, 0}}}));
  EXPECT_FALSE(solver.factor({{{1000000, 0}, {0, -5}}}));
  EXPECT_TRUE(solver.factor({{{1000000, 900000}, {0, 1000000}}}));
}

TEST(EdgeProfile, IsTheErrorFunctionToHalfAStep) {
  for (int s = -1020; s <= 1020; ++s) {
    const double x = s / 256.0;
    const auto value = EdgeProfile::at(s);
    EXPECT_NEAR(value.step / 16384.0, std::erf(x / std::sqrt(2.0)), 4e-5);
    EXPECT_NEAR(value.slope / 16384.0, std::sqrt(2 / M_PI) * std::exp(-x * x / 2), 4e-5);
  }
  EXPECT_NEAR(EdgeProfile::at(100000).step / 16384.0, 1, 1e-4);
  EXPECT_NEAR(EdgeProfile::at(-100000).step / 16384.0, -1, 1e-4);
}

}  // namespace
}  // namespace srd::dsp
