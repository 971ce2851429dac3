// SPDX-License-Identifier: Apache-2.0
// A fit whose loss takes its scale from the frame's own residuals. Optics (15).
#pragma once

#include <algorithm>

#include "dsp/estimate/solver/damped_gauss_newton.hpp"
#include "dsp/estimate/solver/loss.hpp"

namespace srd::dsp {

inline constexpr double kApproachFall = 1e-3;  // fall of the cost at which the next part of a fit takes over
inline constexpr int kScales = 4;              // times that the scale is taken; fixed in between
inline constexpr int kConvexScales = 2;        // of these, with Huber's loss whatever was asked for

// Problem: as DampedGaussNewton takes it, and bool set_loss(Loss, a): takes the scale at a; false where residuals do not
// exist. Tukey's loss has as many minima as there are clusters of corners: Huber's, which has one, brings the surface near.
template <class Problem>
[[nodiscard]] GaussNewtonSummary fit_robustly(Problem& problem, const GaussNewtonOptions& options, Loss loss,
                                              Coefficients<double>& a, NormalEquations& sums) {
  GaussNewtonSummary out;
  for (int turn = 0; turn < kScales; ++turn) {
    if (!problem.set_loss(turn < kConvexScales ? Loss::kHuber : loss, a)) {
      out.stop = Stop::kOutOfDomain;
      return out;
    }
    GaussNewtonOptions now = options;
    if (turn + 1 < kScales) {
      now.epsg = now.epsx = 0;
      now.epsf = kApproachFall;
    }
    // Every turn may take a step; the last ones are short.
    if (options.max_iterations > 0) now.max_iterations = std::max(1, options.max_iterations - out.iterations);
    const GaussNewtonSummary summary = DampedGaussNewton<Problem>(problem, now).minimise(a, sums);
    out.stop = summary.stop;
    out.at_bound = summary.at_bound;
    out.iterations += summary.iterations;
    if (failed(out.stop) || out.stop == Stop::kDeadline) return out;
  }
  return out;
}

}  // namespace srd::dsp
