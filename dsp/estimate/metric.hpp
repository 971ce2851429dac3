// SPDX-License-Identifier: Apache-2.0
// What the size of a corner's residual means.
#pragma once

#include <cstdint>

namespace srd::dsp {

enum class Metric : std::uint8_t {
  kReprojection = 0,  // px, raw image (11)
  kDisparity = 1,     // mm on the bottom plane (9)
  kCollinearity = 2,  // rad, difference of normals (10)
};

}  // namespace srd::dsp
