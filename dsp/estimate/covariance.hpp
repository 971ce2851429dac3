// How sure an estimate is. Optics (17).
#pragma once

#include "dsp/estimate/cholesky.hpp"

namespace srd::dsp {

// Middle of the sandwich H^-1 M H^-1: M = sum J' w2 (B B' sigma2) w2 J with B = de/dq, w = 1/sigma, for unit variance
// factor.
struct Sandwich {
  explicit Sandwich(int parameters) {
    middle.n = parameters;
    middle.reset(parameters);
  }

  template <class S>
  void add(const CornerResidual<S>& residual, const Basis<S>& basis, double weight, const Mat2<double>& e_q) {
    // B'J in place of J: M = sum (w B'J)' (w B'J).
    CornerResidual<double> pushed;
    pushed.e.setZero();
    pushed.by_height = e_q.transpose() * residual.by_height.template cast<double>();
    pushed.by_slope = e_q.transpose() * residual.by_slope.template cast<double>();
    Basis<double> modes{basis.value.template cast<double>(), basis.dx.template cast<double>(),
                        basis.dy.template cast<double>()};
    middle.add(pushed, modes, weight);
  }

  NormalEquations middle;
};

struct Uncertainty {
  InformationMatrix<double> information;     // 1/mm^2
  Coefficients<double> standard_deviation;  // mm
};

// h: J'WJ; sandwich: null where residuals are weighted by their own covariance (reprojection); s2: variance factor > 0.
// False: a pivot of the scaled h (or of the sandwich) is no more than kRankThreshold.
[[nodiscard]] inline bool uncertainty_of(const InformationMatrix<double>& h, const Sandwich* sandwich, double s2,
                                         Uncertainty& out) {
  ScaledCholesky factors;
  if (!factors.factor(h) || !(factors.smallest_pivot() > kRankThreshold)) return false;
  const InformationMatrix<double> inverse = factors.inverse();
  InformationMatrix<double> covariance = s2 * inverse;
  if (sandwich == nullptr) {
    out.information = h / s2;
  } else {
    const InformationMatrix<double> middle = sandwich->middle.matrix();
    ScaledCholesky middle_factors;
    if (!middle_factors.factor(middle) || !(middle_factors.smallest_pivot() > 0)) return false;
    covariance = s2 * inverse.lazyProduct(middle).eval().lazyProduct(inverse);
    out.information = h.lazyProduct(middle_factors.inverse()).eval().lazyProduct(h) / s2;
    out.information = ((out.information + out.information.transpose()) / 2).eval();
  }
  out.standard_deviation = covariance.diagonal().cwiseSqrt();
  return out.standard_deviation.allFinite() && out.information.allFinite();
}

}  // namespace srd::dsp
