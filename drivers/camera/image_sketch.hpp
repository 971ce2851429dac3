// SPDX-License-Identifier: Apache-2.0
// What one image says of why no pattern is found in it: few numbers, taken once, and words made of them at the edge.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "dsp/core/image_view.hpp"

namespace srd {

// No heap. Every eighth pair of rows at most, all columns: each parity of row and column is in it.
class ImageSketch {
 public:
  ImageSketch() = default;
  explicit ImageSketch(const GrayView& image) noexcept;

  [[nodiscard]] bool taken() const { return pixels_ > 0; }
  // The grey level that so many of a thousand pixels do not exceed.
  [[nodiscard]] int level(int permille) const noexcept;
  // Mean difference between neighbours in a row, and between next neighbours, grey levels. A scene's grow with distance; a
  // colour sensor's mosaic differs most between neighbours.
  [[nodiscard]] double neighbours() const noexcept { return mean(next_); }
  [[nodiscard]] double second_neighbours() const noexcept { return mean(second_); }
  // What is wrong with the image and what to look at, one sentence. Empty: not taken.
  [[nodiscard]] std::string diagnosis() const;

 private:
  [[nodiscard]] double mean(std::uint64_t sum) const noexcept {
    return pixels_ == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(pixels_);
  }
  std::array<std::uint32_t, 256> histogram_{};
  std::uint64_t pixels_ = 0, next_ = 0, second_ = 0;
};

}  // namespace srd
