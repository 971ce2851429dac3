// SPDX-License-Identifier: Apache-2.0
// Which pixels of a region show the pattern, where the rest was blanked with a grey between dark and bright.
#pragma once

#include <cstdint>
#include <vector>

#include "dsp/core/image_view.hpp"

namespace srd::host {

// One byte a pixel of the region, row by row; 0: blanked. Blanked is what hangs together with the region's border by
// pixels of dark_below..bright_above, so the greys in the blur of the pattern's own edges stay. Levels: 0..255.
// The region must lie in the image.
[[nodiscard]] std::vector<std::uint8_t> pattern_mask(const GrayView& image, const Region& region, int dark_below,
                                                     int bright_above);

}  // namespace srd::host
