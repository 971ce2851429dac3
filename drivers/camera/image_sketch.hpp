// SPDX-License-Identifier: Apache-2.0
// What one image says of why no pattern is found in it: few numbers, taken once, and words made of them at the edge. Node and
// host tell the same.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "dsp/core/image_view.hpp"

namespace srd {

enum class ImageFault : std::uint8_t { kNone, kNearlyBlack, kDark, kSaturated, kMosaic, kLittleContrast, kBlurred };

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
  // The part of their own contrast that the steepest edges take within 4 px along a row, 0 to 1: a blur of standard deviation
  // s px gives erf(2 / (s sqrt 2)), 0.95 at 1 px, 0.38 at 4 px. Edges of at least half the image's contrast (levels of 1 and
  // 99 %) within 32 px count, however little of the image they fill.
  [[nodiscard]] double steepest() const noexcept;
  // The first that applies. kNone: also when not taken.
  [[nodiscard]] ImageFault fault() const noexcept;
  // What is wrong with the image and what to look at, one sentence. Empty: not taken.
  [[nodiscard]] std::string diagnosis() const;

 private:
  [[nodiscard]] double mean(std::uint64_t sum) const noexcept {
    return pixels_ == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(pixels_);
  }
  using Histogram = std::array<std::uint32_t, 256>;
  [[nodiscard]] static int level_of(const Histogram& histogram, std::uint64_t all, int permille) noexcept;
  void take_edges(const std::uint8_t* row, int width) noexcept;
  Histogram histogram_{}, steps_{};  // of the levels, and of the parts of edges that lie within kReach, 255: all
  std::uint64_t pixels_ = 0, next_ = 0, second_ = 0, edges_ = 0;
};

}  // namespace srd
