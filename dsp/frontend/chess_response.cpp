#include "dsp/frontend/chess_response.hpp"

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

std::array<std::ptrdiff_t, 16> sample_distances(int radius, std::ptrdiff_t stride) {
  std::array<std::ptrdiff_t, 16> at{};
  const auto& offsets = ring(radius);
  for (std::size_t n = 0; n < 16; ++n) at[n] = offsets[n].y * stride + offsets[n].x;
  return at;
}

}  // namespace

std::int16_t response_at(const GrayView& image, int u, int v, const ResponseOptions& options) {
  std::int16_t out = 0;
  response_row(image, v, u, u + 1, options, &out);
  return out;
}

void response_row(const GrayView& image, int v, int u0, int u1, const ResponseOptions& options, std::int16_t* out) {
  const auto at = sample_distances(options.radius, image.stride_bytes);
  const std::uint8_t* row = image.row(v);
  if (options.mean_term) {
    for (int u = u0; u < u1; ++u) out[u - u0] = response<true>(row + u, at, image.stride_bytes);
  } else {
    for (int u = u0; u < u1; ++u) out[u - u0] = response<false>(row + u, at, image.stride_bytes);
  }
}

}  // namespace srd::dsp
