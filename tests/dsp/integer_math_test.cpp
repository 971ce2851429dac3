// SPDX-License-Identifier: Apache-2.0
#include "dsp/core/integer_math.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "dsp/core/fixed_ldl.hpp"
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

// Columns of whole numbers, some of them nearly dependent: what the corner fit hands over.
struct System {
  Eigen::MatrixXd columns;  // the right-hand side last
  std::array<std::array<std::int64_t, 8>, 8> product{};
};

System random_system(std::mt19937& random, double dependence) {
  std::normal_distribution<double> normal;
  System system;
  system.columns.resize(121, 8);
  for (int j = 0; j < 8; ++j) {
    const double size = std::ldexp(1.0, 4 + static_cast<int>(random() % 8));
    for (int i = 0; i < 121; ++i)
      system.columns(i, j) =
          std::round(size * (normal(random) +
                             (j > 0 ? dependence * system.columns(i, j - 1) / system.columns.col(j - 1).norm() * 11 : 0)));
  }
  for (int i = 0; i < 8; ++i)
    for (int j = i; j < 8; ++j)
      system.product[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
          std::llround(system.columns.col(i).dot(system.columns.col(j)));
  return system;
}

TEST(FixedLdl, SolvesAsDoublePrecisionDoes) {
  std::mt19937 random(3);
  for (int k = 0; k < 1000; ++k) {
    const System system = random_system(random, k % 4);
    FixedLdl<7> solver;
    ASSERT_TRUE(solver.factor(system.product));
    const Eigen::MatrixXd j = system.columns.leftCols(7);
    const Eigen::VectorXd y = system.columns.col(7);
    const Eigen::MatrixXd normal = j.transpose() * j;
    const Eigen::VectorXd truth = normal.llt().solve(j.transpose() * y);
    const Eigen::MatrixXd inverse = normal.inverse();
    for (int i = 0; i < 7; ++i) {
      // A thousandth of the deviation that noise of y's size would give the unknown.
      const double tolerance = 1e-3 * y.norm() / 11 * std::sqrt(inverse(i, i)) + 1e-6;
      ASSERT_NEAR(std::ldexp(static_cast<double>(solver.solution(static_cast<std::size_t>(i), 20)), -20), truth(i), tolerance);
    }
    const double rest = (y - j * truth).squaredNorm();
    ASSERT_NEAR(std::ldexp(static_cast<double>(solver.remainder(2)), -2), rest, 1e-4 * y.squaredNorm() + 1);
    const auto block = solver.last_block(40);
    const double unit = std::ldexp(1.0, -40), size = std::sqrt(inverse(5, 5) * inverse(6, 6));
    ASSERT_NEAR(static_cast<double>(block.first) * unit, inverse(5, 5), 5e-3 * inverse(5, 5));
    ASSERT_NEAR(static_cast<double>(block.second) * unit, inverse(6, 6), 5e-3 * inverse(6, 6));
    ASSERT_NEAR(static_cast<double>(block.cross) * unit, inverse(5, 6), 5e-3 * size);
  }
}

TEST(FixedLdl, RefusesColumnsThatDependOnEachOther) {
  FixedLdl<2> solver;
  EXPECT_FALSE(solver.factor({{{1000000, 1000000, 5}, {0, 1000000, 5}, {0, 0, 9}}}));
  EXPECT_FALSE(solver.factor({{{1000000, 0, 5}, {0, 0, 0}, {0, 0, 9}}}));
  EXPECT_FALSE(solver.factor({{{1000000, 0, 5}, {0, -5, 0}, {0, 0, 9}}}));
  EXPECT_TRUE(solver.factor({{{1000000, 900000, 5}, {0, 1000000, 5}, {0, 0, 9}}}));
}

TEST(FixedLdl, LeavesNothingOfARightHandSideThatItsColumnsMake) {
  FixedLdl<2> solver;  // columns (3, 0, 4), (0, 5, 0), y = 7 a - 2 b
  ASSERT_TRUE(solver.factor({{{25, 0, 175}, {0, 25, -50}, {0, 0, 1325}}}));
  EXPECT_NEAR(std::ldexp(static_cast<double>(solver.solution(0, 16)), -16), 7, 1e-3);
  EXPECT_NEAR(std::ldexp(static_cast<double>(solver.solution(1, 16)), -16), -2, 1e-3);
  EXPECT_NEAR(static_cast<double>(solver.remainder(0)), 0, 1);
}

TEST(EdgeProfile, IsTheErrorFunctionAtTheMiddleOfItsCells) {
  for (int s = -4096; s < 4096; ++s) {
    const double middle = (s - (s & 3) + 1.5) / 1024;
    const auto value = EdgeProfile::table(0)[static_cast<std::size_t>(EdgeProfile::cell(s))];
    EXPECT_NEAR(value.step / 16384.0, std::erf(middle / std::sqrt(2.0)), 4e-5);
    EXPECT_NEAR(value.slope / 16384.0, std::sqrt(2 / M_PI) * std::exp(-middle * middle / 2), 4e-5);
  }
}

}  // namespace
}  // namespace srd::dsp
