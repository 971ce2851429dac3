// SPDX-License-Identifier: Apache-2.0
#include "host/fusion/information_sum.hpp"

#include <Eigen/Cholesky>

namespace srd::host {
namespace {

// Of a matrix with a unit diagonal: below, its directions cannot be told apart with numbers that went through int16.
constexpr double kLeastPivot = 1e-8;

// nullopt: not positive definite by a margin.
std::optional<Eigen::MatrixXd> inverse_of(const Eigen::MatrixXd& matrix) {
  if (!(matrix.diagonal().array() > 0).all()) return std::nullopt;
  const Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> factored(scale.asDiagonal() * matrix * scale.asDiagonal());
  if (factored.info() != Eigen::Success || !(factored.vectorD().minCoeff() > kLeastPivot)) return std::nullopt;
  Eigen::MatrixXd inverse = factored.solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
  inverse = (scale.asDiagonal() * inverse * scale.asDiagonal()).eval();
  return Eigen::MatrixXd((inverse + inverse.transpose()) / 2);
}

}  // namespace

std::optional<Contribution> contribution_of(const TimedSurface& board, const BoardMap& map, const Eigen::VectorXd& about) {
  Eigen::MatrixXd covariance = board.covariance;
  if (!map.exact) {
    const Eigen::VectorXd scale = about.size() == map.doubt.cols() ? about : Eigen::VectorXd::Ones(map.doubt.cols());
    const Eigen::MatrixXd doubt = map.doubt * scale.asDiagonal();
    covariance += doubt * doubt.transpose();
  }
  const auto information = inverse_of(covariance);
  if (!information) return std::nullopt;
  Contribution out;
  const Eigen::MatrixXd pushed = map.map.transpose() * *information;
  out.information = pushed * map.map;
  out.information = ((out.information + out.information.transpose()) / 2).eval();
  out.weighted = pushed * (board.coefficients - map.constant);
  return out;
}

std::optional<FusedSurface> add_information(std::span<const Contribution* const> parts, Eigen::Index modes) {
  FusedSurface out;
  out.information = Eigen::MatrixXd::Zero(modes, modes);
  Eigen::VectorXd weighted = Eigen::VectorXd::Zero(modes);
  for (const Contribution* part : parts) {
    out.information += part->information;
    weighted += part->weighted;
  }
  auto covariance = inverse_of(out.information);
  if (!covariance) return std::nullopt;
  out.covariance = std::move(*covariance);
  out.coefficients = out.covariance * weighted;
  return out;
}

}  // namespace srd::host
