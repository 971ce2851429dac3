// SPDX-License-Identifier: Apache-2.0
// ChESS corner response (Bennett & Lasenby 2014). Optics (22).
// |sum response| <= 4 * 510 = 2040, difference response <= 8 * 255 = 2040, mean term <= 16 * 255 = 4080:
// the total lies in [-6120, 2040], and int16 has two bits to spare.
#pragma once

#include <array>
#include <cstdint>

#include "dsp/core/image_view.hpp"

namespace srd::dsp {

struct ResponseOptions {
  int radius = 5;          // px, 5 or 10
  bool mean_term = false;  // also subtract 16 |mean of the circle - mean of the centre cross|: rejects stripes
};

// The response at one pixel; (u, v) at least radius from every border.
[[nodiscard]] std::int16_t response_at(const GrayView& image, int u, int v, const ResponseOptions& options);

// Responses of pixels u0 <= u < u1 of row v into out[0 .. u1 - u0); all at least radius from every border.
void response_row(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out);

// The same where the response is above the threshold (>= 0); elsewhere out is some number that is not above it. Most of an
// image lies far from corners and is told by half the work; maxima above the threshold do not see the difference.
void response_row_above(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t threshold,
                        std::int16_t* out);

// Where here[i], 1 <= i < n - 1, is above the threshold and a maximum of its 3x3 neighbours, of which the rows above and
// below hold the rest; of equal neighbours the first in reading order wins. Writes at most n / 2 + 1 places, in order;
// returns how many.
[[nodiscard]] int row_maxima(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, int n,
                             std::int16_t threshold, std::int32_t* at);

// Responses of a small square of pixels.
struct ResponseWindow {
  static constexpr int kMaxSide = 31, kStride = 32;
  // Row-major; from a row's last pixel up to the next multiple of 8 it holds -32768.
  alignas(64) std::array<std::int16_t, kMaxSide * kStride> at;
  int u0 = 0, v0 = 0, side = 0;  // px
  [[nodiscard]] const std::int16_t* row(int i) const { return at.data() + i * kStride; }
};

// Fills the window's responses; every pixel at least radius from every border.
void response_window(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options, ResponseWindow& window);

struct WindowPeak {
  int row = 0, column = 0;  // the largest response; of equal ones the first in reading order
  std::int16_t response = -32768;
  // Another local maximum above the threshold, at least half as strong and more than 4 px away along u or v.
  bool another = false;
};
// Looks no further than the largest response when that is not above the threshold.
[[nodiscard]] WindowPeak window_peak(const ResponseWindow& window, std::int16_t threshold);

// The definitions; the functions above equal them bit for bit.
namespace scalar {
void response_window(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options, ResponseWindow& window);
[[nodiscard]] WindowPeak window_peak(const ResponseWindow& window, std::int16_t threshold);
void response_row(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out);
[[nodiscard]] int row_maxima(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, int n,
                             std::int16_t threshold, std::int32_t* at);
}  // namespace scalar

}  // namespace srd::dsp
