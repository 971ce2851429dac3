// SPDX-License-Identifier: Apache-2.0
// What a camera's image processor does to edges: I + a (I - G * I), G a Gaussian. Integers, the same on every machine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/recording/image_file.hpp"

namespace srd {

class UnsharpMask {
 public:
  // amount 0..3; radius_px: standard deviation of G, 0.5..4. Reserves all memory.
  UnsharpMask(double amount, double radius_px, int width, int height);

  // Row v of the image, grey levels in 1/256, 0..255 * 256: the caller fills it.
  [[nodiscard]] std::span<std::int32_t> row(int v) {
    return std::span(levels_).subspan(static_cast<std::size_t>(v) * width_, width_);
  }
  // The sharpened image, rounded and limited to 0..255. Beyond its borders the image goes on as its last pixels. No heap.
  void finish(const GrayBuffer& image);

 private:
  std::size_t width_, height_;
  std::int32_t amount_q12_;
  std::vector<std::int32_t> weights_q14_;  // of G, the middle first; they sum to 2^14 over both sides
  std::vector<std::int32_t> levels_, across_, padded_;
};

}  // namespace srd
