// SPDX-License-Identifier: Apache-2.0
// How sure an estimate is. Optics (17).
#pragma once

#include <algorithm>
#include <limits>

#include "dsp/estimate/residual/corner_residual.hpp"
#include "dsp/estimate/solver/cholesky.hpp"
#include "dsp/estimate/solver/rank_report.hpp"

namespace srd::dsp {

// The middle of the sandwich H^-1 M H^-1 is, for unit variance factor and with B = de/dq, w = 1/sigma,
// M = sum J' w2 (B B' sigma2) w2 J = sum (w B'J)' (w B'J): the normal matrix of residuals pushed back through B.
template <class T>
[[nodiscard]] CornerResidual<T> pushed(const CornerResidual<T>& residual, const Mat2<T>& e_q, bool free_index) {
  CornerResidual<T> out;
  out.e = Vec2<T>(0, 0);
  out.by_height = e_q.transpose() * residual.by_height;
  out.by_slope = e_q.transpose() * residual.by_slope;
  if (free_index) out.by_index = e_q.transpose() * residual.by_index;
  return out;
}

struct Uncertainty {
  InformationMatrix<double> information;    // 1/mm^2
  InformationMatrix<double> covariance;     // mm^2
  Coefficients<double> standard_deviation;  // mm
  RankReport rank;
};

// Of h scaled to a unit diagonal, in the 1-norm.
[[nodiscard]] inline double condition_of(const InformationMatrix<double>& h, const InformationMatrix<double>& inverse) {
  const Coefficients<double> root = h.diagonal().cwiseSqrt();
  double most = 0, most_inverse = 0;
  for (Eigen::Index i = 0; i < h.rows(); ++i) {
    most = std::max(most, h.col(i).cwiseAbs().cwiseQuotient(root).sum() / root[i]);
    most_inverse = std::max(most_inverse, inverse.col(i).cwiseAbs().cwiseProduct(root).sum() * root[i]);
  }
  return std::max(1.0, most * most_inverse);  // of a single parameter, rounding alone may leave less
}

// h: J'WJ; middle: of the sandwich, null where residuals are weighted by their own covariance (reprojection); s2:
// variance factor > 0; modes: how many of the parameters are modes. False: a pivot of the scaled h is no more than
// kRankThreshold, as the rank then says.
[[nodiscard]] inline bool uncertainty_of(const InformationMatrix<double>& h, const InformationMatrix<double>* middle, double s2,
                                         int modes, Uncertainty& out) {
  ScaledCholesky factors;
  const bool factored = factors.factor(h);
  out.rank = {};
  out.rank.parameters = out.rank.rank = static_cast<int>(h.rows());
  out.rank.condition = std::numeric_limits<double>::infinity();
  if (!factored || !(factors.smallest_pivot() > kNearlyDependent)) find_dependences(h, modes, out.rank);
  if (!factored || !(factors.smallest_pivot() > kRankThreshold) || out.rank.singular()) return false;
  const InformationMatrix<double> inverse = factors.inverse();
  out.rank.condition = condition_of(h, inverse);
  out.covariance = s2 * inverse;
  if (middle == nullptr) {
    out.information = h / s2;
  } else {
    ScaledCholesky middle_factors;
    if (!middle_factors.factor(*middle) || !(middle_factors.smallest_pivot() > 0)) return false;
    out.covariance = s2 * inverse.lazyProduct(*middle).eval().lazyProduct(inverse);
    out.information = h.lazyProduct(middle_factors.inverse()).eval().lazyProduct(h) / s2;
    out.information = ((out.information + out.information.transpose()) / 2).eval();
  }
  out.standard_deviation = out.covariance.diagonal().cwiseSqrt();
  return out.standard_deviation.allFinite() && out.information.allFinite();
}

}  // namespace srd::dsp
