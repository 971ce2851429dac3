// SPDX-License-Identifier: Apache-2.0
#include "proto/information.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace srd::proto {
namespace {

using Matrix = Eigen::MatrixXd;

// Q diag(e) Q' with eigenvalues spread evenly in the logarithm over the given condition number.
Matrix information_of_condition(int n, double condition, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Matrix gaussian = Matrix::NullaryExpr(n, n, [&](Eigen::Index) { return normal(random); });
  const Matrix q = Eigen::HouseholderQR<Matrix>(gaussian).householderQ();
  Eigen::VectorXd eigenvalues(n);
  for (int i = 0; i < n; ++i) eigenvalues[i] = std::pow(condition, -(n == 1 ? 0.0 : double(i) / (n - 1)));
  const Eigen::VectorXd units = Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index) { return std::exp(2 * normal(random)); });
  return units.asDiagonal() * q * eigenvalues.asDiagonal() * q.transpose() * units.asDiagonal();
}

Eigen::VectorXd true_deviations(const Matrix& information) {
  return information.llt().solve(Matrix::Identity(information.rows(), information.cols())).diagonal().cwiseSqrt();
}

TEST(Information, QuantisationKeepsDeviationsWithinOnePercent) {
  std::mt19937_64 random(1);
  for (const double condition : {1.0, 1e2, 1e4, 1e6}) {
    double worst = 0;
    for (int n = 1; n <= dsp::kMaxModes; ++n)
      for (int draw = 0; draw < 20; ++draw) {
        const Matrix information = information_of_condition(n, condition, random);
        InformationFactor factor;
        ASSERT_TRUE(quantise<double>(information, factor));
        const Eigen::VectorXd stated = standard_deviations(factor);
        const Eigen::VectorXd truth = true_deviations(information);
        worst = std::max(worst, (stated.cwiseQuotient(truth).array() - 1).abs().maxCoeff());
      }
    RecordProperty("worst_relative_error_at_condition_" + std::to_string(static_cast<long>(condition)), std::to_string(worst));
    EXPECT_LT(worst, 0.01) << "condition " << condition;
  }
}

TEST(Information, FactorGivesTheMatrixBack) {
  std::mt19937_64 random(2);
  const Matrix information = information_of_condition(12, 1e3, random);
  InformationFactor factor;
  ASSERT_TRUE(quantise<double>(information, factor));
  const Matrix u = expand(factor);
  const Matrix back = u.transpose() * u;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      EXPECT_NEAR(back(i, j), information(i, j), 1e-4 * std::sqrt(information(i, i) * information(j, j)));
}

TEST(Information, FloatMatricesAreTakenToo) {
  std::mt19937_64 random(3);
  const Matrix information = information_of_condition(8, 100, random);
  InformationFactor factor;
  ASSERT_TRUE(quantise<float>(information.cast<float>(), factor));
  EXPECT_LT((standard_deviations(factor).cwiseQuotient(true_deviations(information)).array() - 1).abs().maxCoeff(), 0.01);
}

TEST(Information, RefusesWhatIsNoInformation) {
  InformationFactor factor;
  dsp::InformationMatrix<double> matrix(2, 2);
  matrix << 1, 2, 2, 1;  // indefinite
  EXPECT_FALSE(quantise<double>(matrix, factor));
  EXPECT_EQ(factor.size, 0);
  matrix << 1, 1, 1, 1;  // singular
  EXPECT_FALSE(quantise<double>(matrix, factor));
  matrix << 1, 0, 0, std::nan("");
  EXPECT_FALSE(quantise<double>(matrix, factor));
  matrix << 1, 0, 0, std::numeric_limits<double>::infinity();
  EXPECT_FALSE(quantise<double>(matrix, factor));
  EXPECT_FALSE(quantise<double>(dsp::InformationMatrix<double>(2, 1), factor));
  EXPECT_FALSE(quantise<double>(dsp::InformationMatrix<double>(0, 0), factor));
  matrix << 4, 0, 0, 25;
  ASSERT_TRUE(quantise<double>(matrix, factor));
  EXPECT_NEAR(standard_deviations(factor)[0], 0.5, 1e-6);
  EXPECT_NEAR(standard_deviations(factor)[1], 0.2, 1e-6);
}

}  // namespace
}  // namespace srd::proto
