// Integer square root, rounded division, and a small fixed-point Cholesky: the front end's arithmetic, equal on every machine.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace srd::dsp {

// floor(sqrt(x)).
[[nodiscard]] constexpr std::uint32_t isqrt(std::uint64_t x) {
  if (x == 0) return 0;
  // A power of two not below the root, then Newton from above: monotone, ends at the floor.
  std::uint64_t root = std::uint64_t{1} << ((std::bit_width(x) + 1) / 2);
  for (;;) {
    const std::uint64_t next = (root + x / root) / 2;
    if (next >= root) return static_cast<std::uint32_t>(root);
    root = next;
  }
}

// a / b to nearest, halves away from zero; b > 0.
[[nodiscard]] constexpr std::int64_t divide_rounded(std::int64_t a, std::int64_t b) {
  return a >= 0 ? (a + b / 2) / b : -((-a + b / 2) / b);
}

// x * 2^-shift to nearest, halves up; shift >= 1.
[[nodiscard]] constexpr std::int64_t shift_rounded(std::int64_t x, int shift) {
  return (x + (std::int64_t{1} << (shift - 1))) >> shift;
}

// Solves A x = y for symmetric positive definite A of size N <= 8 in correlation form: row i is divided by sqrt(A_ii),
// so every number that the elimination meets lies in [-1, 1] and Q30 holds it with 32 bits of headroom for products.
template <int N>
class FixedCholesky {
  static constexpr int kQ = 30;

 public:
  // a: upper triangle used, a[i][i] > 0. False when A is not positive definite by 2^-20 (a pivot of 1e-6).
  [[nodiscard]] bool factor(const std::array<std::array<std::int64_t, N>, N>& a) {
    for (int i = 0; i < N; ++i) {
      if (a[i][i] <= 0) return false;
      root_[i] = isqrt(static_cast<std::uint64_t>(a[i][i]));
      if (root_[i] == 0) return false;
    }
    for (int j = 0; j < N; ++j)
      for (int i = j; i < N; ++i) {
        // a_ij / (root_i root_j) in Q30: |a_ij| <= root_i root_j, split so that nothing exceeds 63 bits.
        // The diagonal too: it exceeds 1 by what the whole-number roots fall short.
        std::int64_t sum = ratio(a[j][i], root_[i], root_[j]);
        for (int k = 0; k < j; ++k) sum -= (l_[i][k] * l_[j][k]) >> kQ;
        if (i == j) {
          if (sum < (std::int64_t{1} << (kQ - 20))) return false;
          l_[i][i] = isqrt(static_cast<std::uint64_t>(sum) << kQ);
        } else {
          l_[i][j] = divide_rounded(sum << kQ, l_[j][j]);
        }
      }
    return true;
  }
  // x_i in units of 2^-q of y_i / a_ii's unit: x = A^-1 y 2^q. y_i should not exceed 2^62 / 2^q.
  void solve(const std::array<std::int64_t, N>& y, int q, std::array<std::int64_t, N>& x) const {
    std::array<std::int64_t, N> z;
    for (int i = 0; i < N; ++i) z[i] = divide_rounded(y[i] * (std::int64_t{1} << q), root_[i]);
    for (int i = 0; i < N; ++i) {
      for (int k = 0; k < i; ++k) z[i] -= multiply(z[k], l_[i][k]);
      z[i] = quotient(z[i], l_[i][i]);
    }
    for (int i = N - 1; i >= 0; --i) {
      for (int k = i + 1; k < N; ++k) z[i] -= multiply(z[k], l_[k][i]);
      z[i] = quotient(z[i], l_[i][i]);
    }
    for (int i = 0; i < N; ++i) x[i] = divide_rounded(z[i], root_[i]);
  }

 private:
  static constexpr std::int64_t ratio(std::int64_t a, std::int64_t ri, std::int64_t rj) {
    // a <= 2^62; a * 2^30 would overflow, so divide by the larger root first with 30 - s bits kept.
    const std::int64_t larger = ri > rj ? ri : rj, smaller = ri > rj ? rj : ri;
    int s = 0;
    std::int64_t m = a < 0 ? -a : a;
    while (s < kQ && m < (std::int64_t{1} << 61)) { m <<= 1; ++s; }
    std::int64_t x = divide_rounded(m, larger);
    int rest = kQ - s;
    while (rest > 0 && x < (std::int64_t{1} << 61)) { x <<= 1; --rest; }
    x = divide_rounded(x, smaller);
    x <<= rest;
    return a < 0 ? -x : x;
  }
  // z * l / 2^30 for |l| <= 2^30: split z so that the product stays below 63 bits.
  static constexpr std::int64_t multiply(std::int64_t z, std::int64_t l) {
    const std::int64_t high = z >> 30, low = z & ((std::int64_t{1} << 30) - 1);
    return high * l + ((low * l) >> 30);
  }
  static constexpr std::int64_t quotient(std::int64_t z, std::int64_t l) {
    const std::int64_t whole = z / l, rest = z - whole * l;
    return (whole << 30) + divide_rounded(rest << 30, l);
  }

  std::array<std::uint32_t, N> root_{};
  std::array<std::array<std::int64_t, N>, N> l_{};
};

}  // namespace srd::dsp
