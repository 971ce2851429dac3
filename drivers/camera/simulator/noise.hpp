// SPDX-License-Identifier: Apache-2.0
// Normal noise of an image as a function of (seed, frame, row, column): no state, the same on every machine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace srd {

class PixelNoise {
 public:
  // sigma: grey levels, 0..64.
  PixelNoise(std::uint64_t seed, double sigma);

  // Adds noise to grey levels in 1/256, rounds, and limits to 0..255. levels and pixels have one length.
  // |deviate| <= 4.33 sigma: the quantiles of 2^16 equal parts of the normal distribution.
  void finish_row(std::uint64_t frame, int row, std::span<const std::int32_t> levels_q8, std::uint8_t* pixels) const;

 private:
  std::uint64_t seed_;
  std::int32_t sigma_q8_;               // grey levels / 256, <= 2^14
  std::vector<std::int16_t> quantile_;  // of (i + 1/2) / 2^16, in 1/4096
};

}  // namespace srd
