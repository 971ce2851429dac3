// SPDX-License-Identifier: Apache-2.0
// Where a lattice expects a corner that was not detected: do the grey levels cross there as at a corner? A blurred or squeezed
// crossing that no one would measure with still tells where the lattice goes on.
#pragma once

#include "dsp/core/image_view.hpp"
#include "dsp/frontend/corner_lattice.hpp"

namespace srd::dsp {

struct FaintCorner {
  float u = 0, v = 0;  // px; within a few tenths of a pixel and a tenth of a step
  float contrast = 0;  // grey levels from dark to bright
  float likeness = 0;  // 0 to 1: of the grey levels' variance, what a corner explains
};

// Looks within half a cell round the map's place, in the lattice's own steps: however squeezed or slanted its squares are.
// bright: of the square between the directions of more columns and more rows. usual_contrast: of the corners round it, grey
// levels from dark to bright. False: the four squares do not alternate, less contrast than a tenth of the usual one and than
// 4 levels, further off than 0.4 steps, or outside of the image.
[[nodiscard]] bool find_faint_corner(const GrayView& image, const CornerLattice::LocalMap& map, bool bright,
                                     float usual_contrast, FaintCorner& corner);

}  // namespace srd::dsp
