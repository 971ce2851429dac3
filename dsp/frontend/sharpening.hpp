// SPDX-License-Identifier: Apache-2.0
// How much a camera has sharpened its image, from the image's own corners: the amount and radius of the unsharp mask with which
// the corner fit's model leaves the least. Image processors sharpen by default; their edges overshoot, and a fit that does not
// know it is late, biased and unsure. Integer arithmetic, no heap.
#pragma once

#include <span>

#include "dsp/core/image_view.hpp"
#include "dsp/frontend/corner_fit.hpp"

namespace srd::dsp {

// starts: where corners may be, with the shapes that a fit starts from, the first 64 are read; a quarter of them may be none.
// Amount 0 unless another one explains clearly more. options.sharpening is not looked at.
[[nodiscard]] Sharpening measure_sharpening(const GrayView& image, std::span<const CornerShape> starts,
                                            const CornerFitOptions& options);

}  // namespace srd::dsp
