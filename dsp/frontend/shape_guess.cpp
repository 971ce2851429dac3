// SPDX-License-Identifier: Apache-2.0
// Where a corner's two edges cross a circle round it: a start for the fit.
#include <array>
#include <cstdlib>

#include "dsp/core/integer_math.hpp"
#include "dsp/frontend/corner_fit.hpp"
#include "dsp/frontend/ring.hpp"

namespace srd::dsp {

namespace {

bool normalise(Direction& d) {
  const std::int64_t x = d.x, y = d.y;
  const std::int64_t length = isqrt(static_cast<std::uint64_t>(x * x + y * y) << 12);  // Q6 above d's unit
  if (length == 0) return false;
  d.x = static_cast<std::int32_t>(divide_rounded(x << 20, length));
  d.y = static_cast<std::int32_t>(divide_rounded(y << 20, length));
  return true;
}

}  // namespace

bool guess_shape(const GrayView& image, int u, int v, int radius, CornerShape& shape) {
  if (!image.contains(u, v, radius)) return false;
  const auto& offsets = ring(radius);
  std::array<int, 16> level;
  int sum = 0;
  for (std::size_t n = 0; n < 16; ++n) {
    level[n] = image.row(v + offsets[n].y)[u + offsets[n].x];
    sum += level[n];
  }
  for (int& l : level) l = 16 * l - sum;  // 16 (I - mean)
  // Where the sign changes between neighbours, by linear interpolation, Q8 px.
  struct Crossing {
    std::int64_t x, y;
  };
  std::array<Crossing, 4> crossing{};
  std::size_t count = 0;
  bool first_falls = false;
  for (std::size_t n = 0; n < 16; ++n) {
    const std::size_t next = (n + 1) % 16;
    if ((level[n] > 0) == (level[next] > 0)) continue;
    if (count == 4) return false;
    if (count == 0) first_falls = level[n] > 0;
    const std::int64_t weight =
        divide_rounded(static_cast<std::int64_t>(std::abs(level[n])) << 8, std::abs(level[n]) + std::abs(level[next]));
    crossing[count].x = (offsets[n].x << 8) + (offsets[next].x - offsets[n].x) * weight;
    crossing[count].y = (offsets[n].y << 8) + (offsets[next].y - offsets[n].y) * weight;
    ++count;
  }
  if (count != 4) return false;
  // Edge 1 joins crossings 0 and 2, edge 2 joins 1 and 3; the corner is where they meet.
  const std::int64_t d1x = crossing[2].x - crossing[0].x, d1y = crossing[2].y - crossing[0].y;
  const std::int64_t d2x = crossing[3].x - crossing[1].x, d2y = crossing[3].y - crossing[1].y;
  const std::int64_t det = d1x * d2y - d1y * d2x;
  if (det == 0) return false;
  const std::int64_t rx = crossing[1].x - crossing[0].x, ry = crossing[1].y - crossing[0].y;
  const std::int64_t t_q12 = ((rx * d2y - ry * d2x) << 12) / det;
  if (t_q12 < 0 || t_q12 > 4096) return false;
  shape.u = Pixel::from_raw((u << 12) + static_cast<std::int32_t>((crossing[0].x << 4) + ((t_q12 * d1x) >> 8)));
  shape.v = Pixel::from_raw((v << 12) + static_cast<std::int32_t>((crossing[0].y << 4) + ((t_q12 * d1y) >> 8)));
  // Clockwise from crossing 0: bright after it when the level rises there. Between crossing 0 and 1 the distance to
  // edge 1 with normal (-d1y, d1x) is negative and the distance to edge 2 with normal (-d2y, d2x) positive.
  shape.n1 = {static_cast<std::int32_t>(-d1y), static_cast<std::int32_t>(d1x)};
  shape.n2 = {static_cast<std::int32_t>(-d2y), static_cast<std::int32_t>(d2x)};
  if (!first_falls) shape.n2 = {-shape.n2.x, -shape.n2.y};
  return normalise(shape.n1) && normalise(shape.n2);
}

}  // namespace srd::dsp
