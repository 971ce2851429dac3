// The step edge seen through a Gaussian blur, in a table: E(s) = erf(s / sqrt 2) and D(s) = E'(s) = sqrt(2/pi) exp(-s^2/2).
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

  struct Value {
    std::int16_t step;   // E, Q14, +-16384
    std::int16_t slope;  // D, Q14, 0..13073
  };
  using Table = std::array<Value, kCells>;

  // Cell of s in Q10, -kReachQ10 <= s < kReachQ10.
  [[nodiscard]] static constexpr int cell(int s_q10) { return (s_q10 + kReachQ10) >> 2; }
  [[nodiscard]] static const Table& table();
};

}  // namespace srd::dsp
