// SPDX-License-Identifier: Apache-2.0
// A frame's information matrix as it travels: its Cholesky factor U, U'U = Lambda (optics (17)), int16 with a float scale
// a column. Positive definite by construction. Standard deviations survive within 1 % (tests/proto/information_test.cpp).
#pragma once

#include <array>
#include <cstdint>

#include "dsp/estimate/estimator/estimator.hpp"

namespace srd::proto {

inline constexpr int kMaxFactorEntries = dsp::kMaxModes * (dsp::kMaxModes + 1) / 2;

struct InformationFactor {
  int size = 0;                                           // columns; 0: not known
  std::array<float, dsp::kMaxModes> scale{};              // > 0
  std::array<std::int16_t, kMaxFactorEntries> entries{};  // by column: U_00, U_01, U_11, U_02, ..; U_jj > 0
  [[nodiscard]] static constexpr int entry_count(int size) { return size * (size + 1) / 2; }
  [[nodiscard]] static constexpr std::size_t index(int row, int column) {
    return static_cast<std::size_t>(column * (column + 1) / 2 + row);
  }
  friend bool operator==(const InformationFactor&, const InformationFactor&) = default;
};

// False, and factor.size 0, when the matrix is not square, not finite, not positive definite, or so nearly singular that a
// diagonal entry is below 1/32767 of its column. Reads the upper triangle.
template <class S>
[[nodiscard]] bool quantise(const dsp::InformationMatrix<S>& information, InformationFactor& factor);

// U, upper triangular.
[[nodiscard]] dsp::InformationMatrix<double> expand(const InformationFactor& factor);

// Standard deviation of each coefficient, mm: roots of the diagonal of (U'U)^-1. Empty when factor.size is 0.
[[nodiscard]] dsp::Coefficients<double> standard_deviations(const InformationFactor& factor);

}  // namespace srd::proto
