// SPDX-License-Identifier: Apache-2.0
// Small symmetric systems, scaled to a unit diagonal before they are factored, so that the pivots tell the rank.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "dsp/estimate/solver/normal_equations.hpp"

namespace srd::dsp {

class ScaledCholesky {
 public:
  // Factors P' D^-1 A D^-1 P = L L' with D^2 = diag(A). False: a diagonal entry that is not positive and finite.
  [[nodiscard]] bool factor(const InformationMatrix<double>& a) {
    const Eigen::Index n = a.rows();
    scale_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      if (!(a(i, i) > 0) || !std::isfinite(a(i, i))) return false;
      scale_[i] = 1 / std::sqrt(a(i, i));
    }
    const InformationMatrix<double> unit = scale_.asDiagonal() * a * scale_.asDiagonal();
    factors_.compute(unit);
    smallest_pivot_ = factors_.vectorD().minCoeff();
    return std::isfinite(smallest_pivot_);
  }

  // In (0, 1] for a positive definite matrix.
  [[nodiscard]] double smallest_pivot() const { return smallest_pivot_; }

  [[nodiscard]] Coefficients<double> solve(const Coefficients<double>& b) const {
    Coefficients<double> x = scale_.cwiseProduct(b);
    factors_.solveInPlace(x);
    return scale_.cwiseProduct(x);
  }

  [[nodiscard]] InformationMatrix<double> inverse() const {
    const Eigen::Index n = scale_.size();
    InformationMatrix<double> out(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      Coefficients<double> unit = Coefficients<double>::Zero(n);
      unit[i] = 1;
      out.col(i) = solve(unit);
    }
    return (out + out.transpose()) / 2;
  }

 private:
  Coefficients<double> scale_;
  Eigen::LDLT<InformationMatrix<double>> factors_{};
  double smallest_pivot_ = 0;
};

}  // namespace srd::dsp
