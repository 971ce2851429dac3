// SPDX-License-Identifier: Apache-2.0
// The step edge as a camera shows it, in tables: E(s) from -1 to 1 across the edge, and D(s) = E'(s); s is the distance from the
// edge in standard deviations of the blur. The lens's part of the blur is a normal distribution; the pixel averages over its
// area, which across an edge of normal n is a box of |nx| and one of |ny| px: optics (24). Both boxes together have the variance
// 1/12 px^2 whatever the direction, blur^2 = lens^2 + 1/12 px^2; what the direction changes is their mixture's shape.
#pragma once

#include <array>
#include <cstdint>

namespace srd::dsp {

// |s| <= 4 standard deviations in cells of 1/256; values in Q14 at the middle of each cell. E is within 0.16 % of the
// contrast, well below the noise of one pixel, and what is left has no mean: the corner does not move by it.
class EdgeProfile {
 public:
  static constexpr int kReachQ10 = 4 << 10;
  static constexpr int kCells = 2 * kReachQ10 / 4;
  // Shape 8 r + k: two boxes, the smaller r/3 of the larger, with k/16 of the variance together, a normal distribution with the
  // rest. Shapes 0: the normal distribution. Edges of which the boxes are more are SharpEdge's.
  static constexpr int kParts = 8, kRatios = 4, kShapes = kParts * kRatios;

  struct Value {
    std::int16_t step;   // E, Q14, +-16384
    std::int16_t slope;  // D, Q14, 0..13073
  };
  using Table = std::array<Value, kCells>;

  // Cell of s in Q10, -kReachQ10 <= s < kReachQ10.
  [[nodiscard]] static constexpr int cell(int s_q10) { return (s_q10 + kReachQ10) >> 2; }
  // Makes the tables, if no detector of this process has done so: milliseconds that no frame should wait for. No heap.
  static void prepare() { (void)mixed(0); }
  // 0 <= shape < kShapes.
  [[nodiscard]] static const Table& table(int shape) { return shape == 0 ? kNormal : mixed(shape); }

  // The shape of an edge with this normal (Q14, unit length) and blur (Q12 px, 0.45 px at least). From 0.73 px on it is within
  // 0.1 % of the contrast of the normal distribution's.
  [[nodiscard]] static int shape_of(std::int32_t nx_q14, std::int32_t ny_q14, std::int64_t blur_q12) {
    constexpr std::int64_t kWideQ12 = 4096 * 73 / 100;
    return blur_q12 >= kWideQ12 ? 0 : sharp_shape_of(nx_q14, ny_q14, blur_q12);
  }

 private:
  static const Table kNormal;
  [[nodiscard]] static const Table& mixed(int shape);
  [[nodiscard]] static int sharp_shape_of(std::int32_t nx_q14, std::int32_t ny_q14, std::int64_t blur_q12);
};

}  // namespace srd::dsp
