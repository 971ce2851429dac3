// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/response_top.hpp"

#include <algorithm>
#include <cstdlib>

namespace srd::dsp {

bool place_at_top(const ResponseWindow& window, int row, int column, CornerShape& shape) {
  if (std::min(row, column) < 2 || std::max(row, column) > window.side - 3) return false;
  // Sums of |response| <= 2040 with weights up to 4 over 25 places: < 2^18.
  std::int64_t sum = 0, u = 0, v = 0, uu = 0, vv = 0, uv = 0;
  for (int i = -2; i <= 2; ++i) {
    const std::int16_t* at = window.row(row + i) + column;
    const int level = at[-2] + at[-1] + at[0] + at[1] + at[2], slope = 2 * (at[2] - at[-2]) + at[1] - at[-1];
    sum += level;
    u += slope;
    uu += 4 * (at[2] + at[-2]) + at[1] + at[-1];
    v += i * level;
    vv += i * i * level;
    uv += i * slope;
  }
  // Gradient and curvatures, both times 700; the normal equations of the paraboloid are diagonal but for the constant.
  const std::int64_t bend_u = 20 * (uu - 2 * sum), bend_v = 20 * (vv - 2 * sum), twist = 7 * uv;
  const std::int64_t det = bend_u * bend_v - twist * twist;
  if (bend_u >= 0 || det <= 0) return false;
  const std::int64_t du = (twist * v - bend_v * u) * 14 * Pixel::kOne / det;
  const std::int64_t dv = (twist * u - bend_u * v) * 14 * Pixel::kOne / det;
  if (std::max(std::abs(du), std::abs(dv)) > Pixel::kOne) return false;
  shape.u = Pixel::from_raw(((window.u0 + column) * Pixel::kOne) + static_cast<std::int32_t>(du));
  shape.v = Pixel::from_raw(((window.v0 + row) * Pixel::kOne) + static_cast<std::int32_t>(dv));
  return true;
}

}  // namespace srd::dsp
