// SPDX-License-Identifier: Apache-2.0
// The corner fit's model and sums where edges are nearly as sharp as a pixel, and sampling is coarser than they are: each pixel's
// own mean over its area, and an unsharp mask as image processors apply it, to pixels. Tens of times the work of corner_sums.
// Integer arithmetic, no heap.
#pragma once

#include <cstdint>

#include "dsp/frontend/corner_fit.hpp"
#include "dsp/frontend/corner_sums.hpp"
#include "dsp/frontend/corner_window.hpp"

namespace srd::dsp {

// Where the model stands; the position is relative to the window's centre.
struct SharpCorner {
  std::int64_t x = 0, y = 0;                  // Q16 px
  Direction n1, n2;                           // Q14
  std::int64_t blur_q12 = 0;                  // px, lens and pixel together, 1183 .. kMostBlurQ12
  std::int16_t mean_q6 = 0, contrast_q8 = 0;  // as in CornerModel
  Sharpening sharpening;
  static constexpr std::int64_t kMostBlurQ12 = 4096 * 6 / 10;
};

// As corner_sums.
void sharp_corner_sums(const CornerWindow& window, const std::uint8_t* pixels, const SharpCorner& corner, CornerSums& sums);

}  // namespace srd::dsp
