// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/noise_threshold.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

namespace srd::dsp {

int noise_threshold(const GrayView& image) {
  constexpr int kRowStep = 8, kMost = 2 * 255;
  std::array<std::uint32_t, kMost + 1> histogram{};
  std::uint32_t all = 0;
  for (int v = 0; v < image.height; v += kRowStep) {
    const std::uint8_t* row = image.row(v);
    for (int u = 1; u + 1 < image.width; ++u) {
      if (row[u] == 0 || row[u] == 255) continue;
      ++histogram[static_cast<std::size_t>(std::abs(row[u - 1] - 2 * row[u] + row[u + 1]))];
      ++all;
    }
  }
  if (all == 0) return kLeastThreshold;
  // The median in hundredths: a difference of d stands for what was rounded to it, d - 1/2 to d + 1/2; 0 for half of that.
  std::uint32_t below = 0;
  int median = 0;
  while (2 * (below + histogram[static_cast<std::size_t>(median)]) < all)
    below += histogram[static_cast<std::size_t>(median++)];
  const std::uint64_t here = histogram[static_cast<std::size_t>(median)];
  const auto part = static_cast<int>((std::uint64_t{50} * (all - 2 * below)) / here);
  const int hundredths = median == 0 ? part / 2 : 100 * median - 50 + part;
  // The second difference has 6 times the variance, and half of a normal distribution lies within 0.674 deviations: 16 s is
  // 9.68 times the median.
  return std::clamp(hundredths * 968 / 10000, kLeastThreshold, kMostThreshold);
}

}  // namespace srd::dsp
