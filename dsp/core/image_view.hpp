// SPDX-License-Identifier: Apache-2.0
// A borrowed 8-bit grey image. Row-major; pixel (u, v) is column u of row v, its centre at (u, v). Does not own.
#pragma once

#include <cstdint>

namespace srd {

struct GrayView {
  const std::uint8_t* pixels = nullptr;
  int width = 0;         // px
  int height = 0;        // px
  int stride_bytes = 0;  // from one row to the next, >= width

  [[nodiscard]] const std::uint8_t* row(int v) const { return pixels + static_cast<std::int64_t>(v) * stride_bytes; }
  [[nodiscard]] bool contains(int u, int v, int margin = 0) const {
    return u >= margin && v >= margin && u < width - margin && v < height - margin;
  }
};

// A region of interest, px, half open: u0 <= u < u1, v0 <= v < v1.
struct Region {
  int u0 = 0, v0 = 0, u1 = 0, v1 = 0;
  [[nodiscard]] bool empty() const { return u1 <= u0 || v1 <= v0; }
};

}  // namespace srd
