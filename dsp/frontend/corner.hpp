// SPDX-License-Identifier: Apache-2.0
// A checkerboard corner in an image.
#pragma once

#include <cstdint>

#include "dsp/core/fixed.hpp"

namespace srd::dsp {

struct Corner {
  Pixel u, v;                   // raw image, px; centre of the top-left pixel is (0, 0)
  std::uint32_t sigma_q12 = 0;  // standard deviation per axis, 1/4096 px; 0: not known
  std::int16_t response = 0;    // ChESS response at the nearest pixel, optics (22)
  // Half sum and half difference of the grey levels of the four sectors: darkness and contrast, grey levels.
  std::uint8_t mean = 0;
  std::uint8_t contrast = 0;
};

}  // namespace srd::dsp
