// SPDX-License-Identifier: Apache-2.0
// Disparity: where the measured ray arrives on the bottom plane against where its corner lies. Optics (9).
#pragma once

#include "dsp/estimate/residual/local_residual.hpp"
#include "dsp/optics/refraction.hpp"

namespace srd::dsp {

// e = b - F, mm. foot: p_xy - F_xy; height: p_z - F_z, mm.
// False as cross().
template <class S>
[[nodiscard]] bool disparity_residual(const Vec3<S>& d, const Vec2<S>& foot, S height, S zx, S zy, const Media<S>& media,
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
