// How sure an estimate is. Optics (17).
#pragma once

#include "dsp/estimate/cholesky.hpp"

namespace srd::dsp {

// The middle of the sandwich H^-1 M H^-1 is, for unit variance factor and with B = de/dq, w = 1/sigma,
// M = sum J' w2 (B B' sigma2) w2 J = sum (w B'J)' (w B'J): the normal matrix of residuals pushed back through B.
template <class T>
[[nodiscard]] CornerResidual<T> pushed(const CornerResidual<T>& residual, const Mat2<T>& e_q) {
  CornerResidual<T> out;
  out.e = Vec2<T>(0, 0);
  out.by_height = e_q.transpose() * residual.by_height;
  out.by_slope = e_q.transpose() * residual.by_slope;
  return out;
}

struct Uncertainty {
  InformationMatrix<double> information;     // 1/mm^2
  Coefficients<double> standard_deviation;  // mm
};

// h: J'WJ; middle: of the sandwich, null where residuals are weighted by their own covariance (reprojection); s2:
// variance factor > 0. False: a pivot of the scaled h is no more than kRankThreshold.
[[nodiscard]] inline bool uncertainty_of(const InformationMatrix<double>& h, const InformationMatrix<double>* middle,
                                         double s2, Uncertainty& out) {
  ScaledCholesky factors;
  if (!factors.factor(h) || !(factors.smallest_pivot() > kRankThreshold)) return false;
  const InformationMatrix<double> inverse = factors.inverse();
  InformationMatrix<double> covariance = s2 * inverse;
  if (middle == nullptr) {
    out.information = h / s2;
  } else {
    ScaledCholesky middle_factors;
    if (!middle_factors.factor(*middle) || !(middle_factors.smallest_pivot() > 0)) return false;
    covariance = s2 * inverse.lazyProduct(*middle).eval().lazyProduct(inverse);
    out.information = h.lazyProduct(middle_factors.inverse()).eval().lazyProduct(h) / s2;
    out.information = ((out.information + out.information.transpose()) / 2).eval();
  }
  out.standard_deviation = covariance.diagonal().cwiseSqrt();
  return out.standard_deviation.allFinite() && out.information.allFinite();
}

}  // namespace srd::dsp
