// SPDX-License-Identifier: Apache-2.0
// What the solver is told. Optics (15).
#pragma once

#include "dsp/optics/surface_model.hpp"

namespace srd::dsp {

struct GaussNewtonOptions {
  double epsg = 0, epsf = 0, epsx = 0;  // 0: that rule is off
  int max_iterations = 50;              // 0: no limit
  Coefficients<double> scale;           // D = diag(scale); empty: all 1, and damping is diag(J'WJ)
  Coefficients<double> lower, upper;    // empty: none
  bool (*deadline)(void*) = nullptr;    // asked once an iteration; true: stop
  void* deadline_context = nullptr;
};

}  // namespace srd::dsp
