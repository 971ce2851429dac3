// SPDX-License-Identifier: Apache-2.0
// How bright an image is, from few of its pixels. Integer, pure.
#pragma once

#include <cstdint>

#include "dsp/core/image_view.hpp"

namespace srd::firmware {

// The mean of 24 x 24 pixels spread over the region (empty: the whole image), in 1/16 grey level: 0 to 4080. The same
// pixels for each image of a size, so that what lies still cancels between frames.
[[nodiscard]] inline int mean_brightness_q4(const GrayView& image, Region region) {
  constexpr int kAcross = 24;
  if (region.empty()) region = {0, 0, image.width, image.height};
  const int width = region.u1 - region.u0, height = region.v1 - region.v0;
  // 576 * 255 * 16 < 2^22.
  std::int32_t sum = 0;
  for (int y = 0; y < kAcross; ++y) {
    const std::uint8_t* row = image.row(region.v0 + (2 * y + 1) * height / (2 * kAcross));
    for (int x = 0; x < kAcross; ++x) sum += row[region.u0 + (2 * x + 1) * width / (2 * kAcross)];
  }
  return sum * 16 / (kAcross * kAcross);
}

}  // namespace srd::firmware
