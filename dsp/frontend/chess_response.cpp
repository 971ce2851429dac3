// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/chess_response.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "dsp/frontend/ring.hpp"

namespace srd::dsp {

namespace {

// p points at the pixel; at[n] are the samples' distances in bytes.
template <bool kMeanTerm>
inline std::int16_t response(const std::uint8_t* p, const std::array<std::ptrdiff_t, 16>& at, std::ptrdiff_t stride) {
  int sum = 0, difference = 0;
  for (std::size_t n = 0; n < 4; ++n) {
    const int a = p[at[n]], b = p[at[n + 4]], c = p[at[n + 8]], d = p[at[n + 12]];
    sum += std::abs((a + c) - (b + d));
    difference += std::abs(a - c) + std::abs(b - d);
  }
  int total = sum - difference;
  if constexpr (kMeanTerm) {
    int circle = 0;
    for (const std::ptrdiff_t n : at) circle += p[n];
    const int cross = p[0] + p[1] + p[-1] + p[stride] + p[-stride];
    // 16 |circle/16 - cross/5|, rounded down.
    total -= std::abs(5 * circle - 16 * cross) / 5;
  }
  return static_cast<std::int16_t>(total);
}

}  // namespace

std::int16_t response_at(const GrayView& image, int u, int v, const ResponseOptions& options) {
  std::int16_t out = 0;
  scalar::response_row(image, v, u, u + 1, options, &out);
  return out;
}

namespace scalar {

void response_row(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out) {
  const auto at = sample_distances(options.radius, image.stride_bytes);
  const std::uint8_t* row = image.row(v);
  if (options.mean_term) {
    for (int u = u0; u < u1; ++u) out[u - u0] = response<true>(row + u, at, image.stride_bytes);
  } else {
    for (int u = u0; u < u1; ++u) out[u - u0] = response<false>(row + u, at, image.stride_bytes);
  }
}

int row_maxima(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, int n, std::int16_t threshold,
               std::int32_t* at) {
  int count = 0;
  for (int i = 1; i + 1 < n; ++i) {
    const std::int16_t r = here[i];
    if (r > threshold && r > above[i - 1] && r > above[i] && r > above[i + 1] && r > here[i - 1] && r >= here[i + 1] &&
        r >= below[i - 1] && r >= below[i] && r >= below[i + 1])
      at[count++] = i;
  }
  return count;
}

void response_window(const GrayView& image, int u0, int v0, int side, const ResponseOptions& options, ResponseWindow& window) {
  window.u0 = u0;
  window.v0 = v0;
  window.side = side;
  for (int i = 0; i < side; ++i) {
    std::int16_t* row = window.at.data() + i * ResponseWindow::kStride;
    scalar::response_row(image, v0 + i, u0, u0 + side, options, row);
    std::fill(row + side, row + (side + 7) / 8 * 8, std::int16_t{-32768});
  }
}

WindowPeak window_peak(const ResponseWindow& window, std::int16_t threshold) {
  constexpr int kPlateau = 4;  // the first maximum's own
  WindowPeak peak;
  for (int i = 0; i < window.side; ++i)
    for (int j = 0; j < window.side; ++j)
      if (window.row(i)[j] > peak.response) peak = {i, j, window.row(i)[j], false};
  if (peak.response <= threshold) return peak;
  for (int i = 1; i + 1 < window.side; ++i)
    for (int j = 1; j + 1 < window.side; ++j) {
      const std::int16_t* at = window.row(i) + j;
      if (at[0] <= threshold || 2 * at[0] < peak.response) continue;
      if (std::max(std::abs(i - peak.row), std::abs(j - peak.column)) <= kPlateau) continue;
      if (at[0] >= at[-1] && at[0] >= at[1] && at[0] >= at[-ResponseWindow::kStride] && at[0] >= at[ResponseWindow::kStride])
        peak.another = true;
    }
  return peak;
}

}  // namespace scalar
}  // namespace srd::dsp
