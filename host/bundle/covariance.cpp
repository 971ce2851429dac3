// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/covariance.hpp"

#include <ceres/crs_matrix.h>

#include <Eigen/Eigenvalues>

namespace srd::bundle {

namespace {

constexpr double kMinEigenvalue = 1e-13;

// J'J of a matrix with few entries a row.
Eigen::MatrixXd information(const ceres::CRSMatrix& jacobian) {
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(jacobian.num_cols, jacobian.num_cols);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    const int begin = jacobian.rows[static_cast<std::size_t>(row)], end = jacobian.rows[static_cast<std::size_t>(row) + 1];
    for (int a = begin; a < end; ++a) {
      const auto i = static_cast<std::size_t>(a);
      for (int b = begin; b <= a; ++b) {
        const auto j = static_cast<std::size_t>(b);
        h(jacobian.cols[i], jacobian.cols[j]) += jacobian.values[i] * jacobian.values[j];
      }
    }
  }
  return h.selfadjointView<Eigen::Lower>();
}

}  // namespace

Result<Covariance> covariance(ceres::Problem& problem, const std::vector<Block>& blocks) {
  ceres::Problem::EvaluateOptions options;
  for (const Block& block : blocks) options.parameter_blocks.push_back(block.values);
  ceres::CRSMatrix jacobian;
  if (!problem.Evaluate(options, nullptr, nullptr, nullptr, &jacobian)) return Errc::kOutOfDomain;
  Eigen::MatrixXd h = information(jacobian);
  const Eigen::VectorXd diagonal = h.diagonal();
  if (!diagonal.allFinite() || !(diagonal.minCoeff() > 0)) return Errc::kSingular;
  const Eigen::VectorXd unit = diagonal.cwiseSqrt().cwiseInverse();
  h = unit.asDiagonal() * h * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(h);
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()[0] > kMinEigenvalue)) return Errc::kSingular;
  Covariance result;
  result.weakness = {solver.eigenvalues()[0], solver.eigenvectors().col(0)};
  const Eigen::MatrixXd half =
      unit.asDiagonal() * solver.eigenvectors() * solver.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
  result.matrix = half * half.transpose();
  return result;
}

}  // namespace srd::bundle
