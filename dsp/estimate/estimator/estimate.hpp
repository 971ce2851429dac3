// SPDX-License-Identifier: Apache-2.0
// A fitted surface, how sure it is, and how it was found. Optics (17), (17a).
#pragma once

#include "dsp/estimate/solver/information.hpp"
#include "dsp/estimate/solver/rank_report.hpp"
#include "dsp/estimate/solver/stop.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd::dsp {

template <class S>
struct Estimate {
  Stop stop = Stop::kTooFewCorners;
  Coefficients<S> coefficients;        // mm
  InformationMatrix<S> information;    // 1/mm^2; inverse of the covariance (17)
  Coefficients<S> standard_deviation;  // mm; 1e-4 for coefficients that equal bounds hold
  S height_deviation = 0;              // mm; of the surface's height, rms over the places of the bottom points (17a)
  S mean_error = 0;                    // mean |e| over the corners used, in the metric's unit
  S reprojection_rms = 0;              // px per axis over the corners used, whatever the metric
  S cost = 0;                          // sum of rho, of squared weighted residuals
  S loss_scale = 0;                    // of one component of a weighted residual, as the loss took it; 0: no loss
  // s2: squared one-step pixel residuals in units of sigma over (residuals - parameters), whatever the metric; 1 when
  // sigmas are right; 0 when there are no more residuals than parameters, and the covariance then takes s2 = 1. With a
  // loss, psi over its mean derivative stands for the residuals.
  S variance_factor = 0;
  // With free_index: of water, and its standard deviation; else the index given, and 0.
  S index = 0, index_deviation = 0;
  // What the corners tell apart; of kSingular and kIndexUndetermined too, and then the reason. With 0 parameters: the
  // fit did not come so far.
  RankReport rank;
  int iterations = 0;
  int corners_used = 0;  // without those that Tukey's loss gives no weight
  int start_used = 0;    // which of the starts was best
  bool at_bound = false;
};

}  // namespace srd::dsp
