// SPDX-License-Identifier: Apache-2.0
// What the corners can tell apart, and what not.
#pragma once

#include <array>
#include <cstdint>

#include "dsp/estimate/solver/information.hpp"

namespace srd::dsp {

// A parameter counts as undetermined when a pivot of the unit-diagonal matrix, 1 - R^2 of its derivatives on those of the
// others, is no more than this: its standard deviation would be over 300 times what it is alone. Full patterns have
// pivots above 1e-3 even with 24 modes; rounding of float derivatives reaches 1e-6.
inline constexpr double kRankThreshold = 1e-5;
// Up to here a parameter is hardly determined: over 30 times the deviation that it has alone.
inline constexpr double kNearlyDependent = 1e-3;

// One parameter that the corners show as a combination of others.
struct Dependence {
  int parameter = 0;  // its place in the mode list; the number of modes: the index of water
  double pivot = 0;   // 1 - R^2; 0 too for a parameter without any effect on the corners, which has no others
  std::array<std::uint8_t, kMaxParameters> others{};  // with at least a tenth of the largest share, largest first
  int n_others = 0;
};

struct RankReport {
  int parameters = 0;
  int rank = 0;          // pivots above kRankThreshold
  double condition = 0;  // of the unit-diagonal matrix, in the 1-norm; infinite below full rank, 0: no matrix was made
  std::array<Dependence, kMaxParameters> dependences{};  // pivots up to kNearlyDependent, largest first
  int n_dependences = 0;

  [[nodiscard]] bool singular() const { return rank < parameters; }
};

// Pivoted Cholesky of a (information, both triangles) in correlation form. Parameters from the place modes on are
// explained by the modes and never the other way round. Leaves the condition alone. No heap.
void find_dependences(const InformationMatrix<double>& a, int modes, RankReport& out);
// How the last parameter depends on the others, however little. a: positive definite.
[[nodiscard]] Dependence dependence_of_last(const InformationMatrix<double>& a);

}  // namespace srd::dsp
