// SPDX-License-Identifier: Apache-2.0
// Small symmetric systems in integers: least squares from the products of its columns, without a square root.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "dsp/core/integer_math.hpp"

namespace srd::dsp {

// Least squares of N unknowns from the (N+1)^2 products of its columns and, last, the right-hand side. Columns are first
// scaled by powers of two to squares in [2^30, 2^32), so that every number met below is < 2^32, and l < 2^27 in Q20.
template <int N>
class FixedLdl {
  static constexpr int kQ = 20;
  static constexpr std::int64_t kMinPivot = std::int64_t{1} << 18;  // of 2^30..2^32

 public:
  using Products = std::array<std::array<std::int64_t, N + 1>, N + 1>;

  // Upper triangle used; 0 <= product < 2^33 on the diagonal, and |p_ij|^2 <= p_ii p_jj. False when the columns depend
  // on each other.
  [[nodiscard]] bool factor(const Products& product) {
    for (std::size_t i = 0; i <= N; ++i) {
      if (product[i][i] <= 0 && i < N) return false;
      // A negative shift only for sums of more than 2^32.
      shift_[i] = (32 - static_cast<int>(std::bit_width(static_cast<std::uint64_t>(product[i][i])))) >> 1;
    }
    each<N + 1>([&](auto i) __attribute__((always_inline)) {
      each<i + 1>([&](auto j) __attribute__((always_inline)) {
        const int shift = shift_[i] + shift_[j];
        a_[i][j] = shift >= 0 ? product[j][i] << shift : product[j][i] >> -shift;
      });
    });
    bool sound = true;
    each<N>([&](auto j) __attribute__((always_inline)) { sound = sound && eliminate<j>(); });
    if (!sound) return false;
    each<N>([&](auto k) __attribute__((always_inline)) {
      constexpr std::size_t j = N - 1 - k;
      std::int64_t x = l_[N][j];
      each<k>([&](auto i) __attribute__((always_inline)) { x -= (l_[j + 1 + i][j] * x_[j + 1 + i]) >> kQ; });
      x_[j] = x;
    });
    return true;
  }
  // Unknown i with 'bits' fraction bits, in units of the right-hand side over the column.
  [[nodiscard]] std::int64_t solution(std::size_t i, int bits) const {
    return scaled(x_[i], shift_[i] - shift_[N] - kQ + bits);
  }
  // Sum of squares that the solution leaves, with 'bits' fraction bits; never below 0.
  [[nodiscard]] std::int64_t remainder(int bits) const { return a_[N][N] <= 0 ? 0 : scaled(a_[N][N], bits - 2 * shift_[N]); }
  // The last two unknowns' block of the inverse of the normal matrix, with 'bits' fraction bits.
  struct Block {
    std::int64_t first, cross, second;
  };
  [[nodiscard]] Block last_block(int bits) const {
    constexpr std::size_t f = N - 2, s = N - 1;
    const std::int64_t second = (std::int64_t{1} << 60) / a_[s][s];  // 2^28 .. 2^42
    const std::int64_t l = l_[s][f] >> 10;                           // Q10: enough for a deviation
    const std::int64_t cross = -((l * second) >> 10);
    const std::int64_t first = (std::int64_t{1} << 60) / a_[f][f] - (cross >> 10) * l;
    return {scaled(first, 2 * shift_[f] - 60 + bits), scaled(cross, shift_[f] + shift_[s] - 60 + bits),
            scaled(second, 2 * shift_[s] - 60 + bits)};
  }

 private:
  // f of 0 .. Count - 1 as constants: loops of a few steps each, which a compiler leaves as loops, cost three times as much.
  template <std::size_t Count, class F>
  [[gnu::always_inline]] static constexpr void each(F f) {
    [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
      (f(std::integral_constant<std::size_t, I>()), ...);
    }
    (std::make_index_sequence<Count>());
  }

  // Column j out of all that follow. False: too little is left of it.
  template <std::size_t j>
  [[gnu::always_inline]] bool eliminate() {
    const std::int64_t pivot = a_[j][j];
    const int spare = 32 - static_cast<int>(std::bit_width(static_cast<std::uint64_t>(pivot)));
    if (pivot < kMinPivot || spare < 0) return false;
    const std::int64_t inverse = (std::int64_t{1} << 62) / (pivot << spare);  // in (2^30, 2^31]
    each<N - j>([&](auto i)
                    __attribute__((always_inline)) { l_[j + 1 + i][j] = (a_[j + 1 + i][j] * inverse) >> (62 - kQ - spare); });
    each<N - j>([&](auto i) __attribute__((always_inline)) {
      const std::int64_t l = l_[j + 1 + i][j];
      each<i + 1>([&](auto k) __attribute__((always_inline)) { a_[j + 1 + i][j + 1 + k] -= (l * a_[j + 1 + k][j]) >> kQ; });
    });
    return true;
  }

  static constexpr std::int64_t scaled(std::int64_t x, int shift) {
    if (shift >= 0) return x * (std::int64_t{1} << (shift < 31 ? shift : 31));
    return shift < -62 ? 0 : shift_rounded(x, -shift);
  }

  std::array<int, N + 1> shift_{};
  std::array<std::array<std::int64_t, N + 1>, N + 1> a_{}, l_{};
  std::array<std::int64_t, N> x_{};
};

}  // namespace srd::dsp
