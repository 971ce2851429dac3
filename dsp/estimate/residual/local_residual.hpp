// SPDX-License-Identifier: Apache-2.0
// A residual along the measured ray before the chain rule: what disparity and collinearity have in common.
#pragma once

#include "dsp/core/linear_algebra.hpp"

namespace srd::dsp {

// e as a function of the surface point p, the direction d and the slopes there.
template <class S>
struct LocalResidual {
  Vec2<S> e;
  Mat23<S> by_p, by_d;
  Mat2<S> by_slope;
  Vec2<S> by_index;  // by the index of water; only when asked for
};

}  // namespace srd::dsp
