// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator/noise.hpp"

#include <algorithm>

#include "drivers/camera/simulator/stable_math.hpp"

namespace srd {

namespace {

constexpr std::size_t kParts = 65536;
constexpr double kDeviateUnit = 4096;

// Upper half by Newton from the part below; the lower half mirrors it.
std::vector<std::int16_t> normal_quantiles() {
  constexpr double kSqrt2Pi = 2.5066282746310005024;
  std::vector<std::int16_t> table(kParts);
  double z = 0;
  for (std::size_t i = kParts / 2; i < kParts; ++i) {
    const double target = (static_cast<double>(i) + 0.5) / static_cast<double>(kParts) - 0.5;
    for (int step = 0; step < 6; ++step) {
      const double miss = stable::normal_cdf_half(z) - target;
      const double change = miss * kSqrt2Pi / stable::exp_negative(-0.5 * z * z);
      z -= change;
      if (change < 1e-7 && change > -1e-7) break;
    }
    const auto q = static_cast<std::int16_t>(z * kDeviateUnit + 0.5);
    table[i] = q;
    table[kParts - 1 - i] = static_cast<std::int16_t>(-q);
  }
  return table;
}

}  // namespace

PixelNoise::PixelNoise(std::uint64_t seed, double sigma)
    : seed_(stable::mix(seed + 1)), sigma_q8_(static_cast<std::int32_t>(sigma * 256 + 0.5)) {
  if (sigma_q8_ > 0) quantile_ = normal_quantiles();
}

template <class Place>
void PixelNoise::each(std::uint64_t frame, int row, std::span<const std::int32_t> levels_q8, Place place) const {
  const std::size_t width = levels_q8.size();
  if (sigma_q8_ == 0) {
    for (std::size_t u = 0; u < width; ++u) place(u, levels_q8[u]);
    return;
  }
  // One key a row; the counter of a key runs over blocks of four pixels.
  const std::uint64_t key = stable::mix(seed_ ^ stable::mix((frame << 16) + static_cast<std::uint64_t>(row) + 1));
  for (std::size_t u = 0; u < width;) {
    std::uint64_t bits = stable::mix(key + u);
    const std::size_t end = std::min(u + 4, width);
    for (; u < end; ++u, bits >>= 16)
      // |deviate sigma| < 17740 * 2^14 < 2^29: int32 has 2 bits to spare.
      place(u, levels_q8[u] + ((quantile_[bits & 0xFFFF] * sigma_q8_) >> 12));
  }
}

void PixelNoise::add_row(std::uint64_t frame, int row, std::span<std::int32_t> levels_q8) const {
  each(frame, row, levels_q8, [&](std::size_t u, std::int32_t q8) { levels_q8[u] = std::clamp(q8, 0, 255 << 8); });
}

void PixelNoise::finish_row(std::uint64_t frame, int row, std::span<const std::int32_t> levels_q8, std::uint8_t* pixels) const {
  each(frame, row, levels_q8,
       [&](std::size_t u, std::int32_t q8) { pixels[u] = static_cast<std::uint8_t>(std::clamp((q8 + 128) >> 8, 0, 255)); });
}

}  // namespace srd
