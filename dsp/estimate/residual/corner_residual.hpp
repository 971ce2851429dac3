// SPDX-License-Identifier: Apache-2.0
// The residual of a corner and all that its derivatives need.
#pragma once

#include "dsp/core/linear_algebra.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd::dsp {

// e, and de/da_j = by_height phi_j + by_slope (phi_j,x , phi_j,y) with the modes taken at the surface point.
template <class T>
struct CornerResidual {
  Vec2<T> e;
  Vec2<T> by_height;
  Mat2<T> by_slope;
  Vec2<T> by_index;  // de by the index of water; set when the optics say that it is free
};

}  // namespace srd::dsp
