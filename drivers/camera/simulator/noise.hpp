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

  // Adds noise to grey levels in 1/256 and limits them to 0..255, as finish_row does before it rounds.
  void add_row(std::uint64_t frame, int row, std::span<std::int32_t> levels_q8) const;
  // Adds noise to grey levels in 1/256, rounds, and limits to 0..255. levels and pixels have one length.
  // |deviate| <= 4.33 sigma: the quantiles of 2^16 equal parts of the normal distribution.
  void finish_row(std::uint64_t frame, int row, std::span<const std::int32_t> levels_q8, std::uint8_t* pixels) const;

 private:
  // place(u, level) for each pixel of the row with its noise added.
  template <class Place>
  void each(std::uint64_t frame, int row, std::span<const std::int32_t> levels_q8, Place place) const;
  std::uint64_t seed_;
  std::int32_t sigma_q8_;               // grey levels / 256, <= 2^14
  std::vector<std::int16_t> quantile_;  // of (i + 1/2) / 2^16, in 1/4096
};

}  // namespace srd
