// SPDX-License-Identifier: Apache-2.0
// One edge nearly as sharp as a pixel, for its own direction and blur: what tables of a few shapes are too coarse for. The step
// edge of the lens's normal distribution, averaged over the pixel's two boxes in closed form, optics (24a).
// Integer arithmetic, no heap.
#pragma once

#include <cstdint>

namespace srd::dsp {

class SharpEdge {
 public:
  // Q14 each. step: E, +-1. slope: blur dE/dx. bend: blur^2 d2E/dx2, which is dE/d(ln blur), as the blur grows by the lens alone.
  // Both by the blur of the whole pixel.
  struct Value {
    std::int32_t step, slope, bend;
  };
  // Normal Q14, unit length; blur Q12 px, of lens and pixel together, >= 1183; of a square 1/parts of the pixel's side.
  SharpEdge(std::int32_t nx_q14, std::int32_t ny_q14, std::int64_t blur_q12, int parts);
  // At this distance of the square's centre from the edge, Q16 px.
  [[nodiscard]] Value at(std::int64_t x_q16) const;

 private:
  std::int64_t outer_, inner_;    // half sum and half difference of the boxes, Q16 px
  std::int64_t reach_;            // beyond it E is +-1, Q16 px
  std::int64_t lens_, per_lens_;  // Q16
  std::int64_t per_wide_;         // 1 / the lens's blur that the bend is taken with, Q16
  std::int64_t blur_;             // Q12
  std::int64_t per_area_;         // 1 / (box box), Q16
};

}  // namespace srd::dsp
