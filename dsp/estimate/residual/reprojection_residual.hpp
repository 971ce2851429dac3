// SPDX-License-Identifier: Apache-2.0
// Residual of one corner in the raw image, px, exact. Optics (11).
#pragma once

#include "dsp/estimate/residual/corner_residual.hpp"
#include "dsp/estimate/residual/prepared_corner.hpp"

namespace srd::dsp {

// corner.foot: start and result. basis: filled at the surface point, unless null; then by_height, by_slope stay unset.
// False as sight().
template <class S>
[[nodiscard]] bool reprojection_residual(const Optics<S>& optics, const Coefficients<S>& a, PreparedCorner<S>& corner,
                                         Basis<S>* basis, CornerResidual<S>& out) {
  Sighting<S> seen;
  if (!sight<S>(optics, a, corner, basis, basis != nullptr, seen)) return false;
  out.e = seen.pixel - corner.pixel;
  if (basis == nullptr) return true;
  out.by_height = seen.by_height;
  out.by_slope = seen.by_slope;
  if (optics.free_index) out.by_index = seen.by_index;
  return true;
}

}  // namespace srd::dsp
