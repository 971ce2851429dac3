// SPDX-License-Identifier: Apache-2.0
// The pixels that the corner fit reads: a square window, row by row, as a list that vectors take without gaps.
#pragma once

#include <array>
#include <cstdint>

namespace srd::dsp {

inline constexpr int kMinHalfWindow = 3, kMaxHalfWindow = 8;

// Offsets from the window's centre, px. What follows the last pixel up to a multiple of 64 has weight 0.
struct CornerWindow {
  static constexpr int kRoom = 320;
  alignas(64) std::array<std::int16_t, kRoom> du{}, dv{};
  alignas(64) std::array<std::int16_t, kRoom> one{};  // 1 in Q11; 0 after the last pixel
  int size = 0;
};

// half_window: kMinHalfWindow .. kMaxHalfWindow.
[[nodiscard]] const CornerWindow& corner_window(int half_window);
// Every second row of it: parity 0 with the rows 0, +-2, .. of the centre, 1 with those between.
[[nodiscard]] const CornerWindow& corner_window_rows(int half_window, int parity);

}  // namespace srd::dsp
