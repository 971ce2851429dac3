// SPDX-License-Identifier: Apache-2.0
// A residual along the measured ray before the chain rule, and its form on the bottom plane.
#pragma once

#include "dsp/optics/crossing.hpp"

namespace srd::dsp {

// e as a function of the surface point p, the direction d and the slopes there.
template <class S>
struct LocalResidual {
  Vec2<S> e;
  Mat23<S> by_p, by_d;
  Mat2<S> by_slope;
  Vec2<S> by_index;  // by the index of water; only when asked for
};

// Disparity difference e = b - F, mm. Optics (9). foot: p_xy - F_xy; height: p_z - F_z, mm.
// False as cross().
template <class S>
[[nodiscard]] bool disparity_difference(const Vec3<S>& d, const Vec2<S>& foot, S height, S zx, S zy, const Media<S>& media,
                                        LocalResidual<S>& out, bool index_derivative = false) {
  Crossing<S> crossing;
  if (!cross(d, zx, zy, height, media, true, crossing, index_derivative)) return false;
  out.e = foot + crossing.offset;
  out.by_p << Mat2<S>::Identity(), crossing.by_height;
  out.by_d = crossing.by_direction;
  out.by_slope = crossing.by_slope;
  if (index_derivative) out.by_index = crossing.by_index;
  return true;
}

}  // namespace srd::dsp
