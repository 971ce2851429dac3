// SPDX-License-Identifier: Apache-2.0
// Sums of the corner fit over the window's pixels: the products of its columns and the residual. 16-bit arithmetic.
//
// Model at a pixel, optics (23), s_i = distance from edge i in blurs: I = m + c B, B = E(s1) E(s2) + rho D(s1) D(s2).
// Columns: 1; B; s1 D1 E2 + s2 E1 D2 (blur); along_i times the move column (turn of edge i); D1 E2, E1 D2
// (move along the normals, times -c/blur).
// Where the camera has sharpened by an unsharp mask, I + a (I - G * I) with a Gaussian G, B is B + a (B - W), W the bracket of
// the blur that G widens, optics (25), and so is each of its derivatives.
//
// Ranges, w <= 8 (|offset| <= 11.4 px): every column stays below 3320 and the residual at 4080, so that 128 products sum
// to less than 2^31; larger windows are summed in parts. Of a sharpened image the columns stay within 5790, and 64 products.
#pragma once

#include <array>
#include <cstdint>

#include "dsp/frontend/corner_window.hpp"

namespace srd::dsp {

// Where the model stands, in the units of the kernel.
struct CornerModel {
  // s_i = across[i].x du + across[i].y dv + across[i].at, Q10, cut off at 16 bits; the position along edge i likewise, Q10 px.
  // |x du|, |y dv| < 2^15 over the window.
  struct Line {
    std::int16_t x = 0, y = 0, at = 0;
  };
  std::array<Line, 2> across, along;
  std::array<std::uint8_t, 2> shape{};  // EdgeProfile's, of each edge
  // The wider bracket W: its distances in its own blur, its edges' shapes, blur / wider blur. amount 0: not sharpened.
  struct Mask {
    std::int16_t amount_q13 = 0;  // 0..kMostAmountQ13
    std::int16_t narrower_q15 = 0;
    std::array<Line, 2> across;
    std::array<std::uint8_t, 2> shape{};
  } mask;
  static constexpr std::int16_t kMostAmountQ13 = 3 << 13;
  static constexpr std::int16_t kNearlyCutOffQ6 = 12 << 6;  // grey levels
  std::int16_t rho_q15 = 0;                                 // n1.n2
  std::int16_t mean_q6 = 0;                                 // grey levels
  std::int16_t contrast_q8 = 0;                             // grey levels, half difference of bright and dark
};

struct CornerSums {
  enum Column { kMean, kContrast, kBlur, kTurn1, kTurn2, kMove1, kMove2, kResidual, kColumns };
  // Fraction bits of each column; the residual's are of a grey level.
  static constexpr std::array<int, kColumns> kQ{11, 11, 10, 8, 8, 11, 11, 5};
  // Upper triangle of the products: at [i][j], j >= i.
  std::array<std::array<std::int64_t, kColumns>, kColumns> product{};
};

// pixels: the window's, in its order, with room for CornerWindow::kRoom.
void corner_sums(const CornerWindow& window, const std::uint8_t* pixels, const CornerModel& model, CornerSums& sums);

// The definition; the other equals it bit for bit.
namespace scalar {
void corner_sums(const CornerWindow& window, const std::uint8_t* pixels, const CornerModel& model, CornerSums& sums);
}

}  // namespace srd::dsp
