// SPDX-License-Identifier: Apache-2.0
// Sums of the normal equations over corners, several at once.
#pragma once

#include <array>

#include "dsp/core/lanes.hpp"
#include "dsp/estimate/residual/corner_residual.hpp"
#include "dsp/estimate/solver/normal_equations.hpp"

namespace srd::dsp {

// Collects J'WJ and J'We over the lanes. In double whatever T is: pivots of nearly dependent modes are differences of
// these sums, and float would leave none of their digits.
template <class T>
class NormalSums {
 public:
  explicit NormalSums(int parameters) : n_(parameters) {
    for (int i = 0; i < n_; ++i) {
      jte_[static_cast<std::size_t>(i)] = 0;
      for (int j = 0; j <= i; ++j) jtj_[at(i, j)] = 0;
    }
  }

  // Adds the two rows of a corner, de/da_j = by_height phi_j + by_slope grad phi_j; a parameter beyond the modes is the
  // index of water.
  void add(const CornerResidual<T>& residual, const Basis<T>& basis, T weight) {
    std::array<Rows, kMaxParameters> rows;
    const int modes = static_cast<int>(basis.value.size());
    if (modes < n_) {
      widen(residual.by_index.x() * weight, &rows[static_cast<std::size_t>(modes)][0]);
      widen(residual.by_index.y() * weight, &rows[static_cast<std::size_t>(modes)][kParts]);
    }
    const Vec2<T> h = residual.by_height * weight, e = residual.e * weight;
    const Mat2<T> g = residual.by_slope * weight;
    for (int i = 0; i < modes; ++i) {
      Rows& row = rows[static_cast<std::size_t>(i)];
      widen(h.x() * basis.value[i] + g(0, 0) * basis.dx[i] + g(0, 1) * basis.dy[i], &row[0]);
      widen(h.y() * basis.value[i] + g(1, 0) * basis.dx[i] + g(1, 1) * basis.dy[i], &row[kParts]);
    }
    Rows errors;
    widen(e.x(), &errors[0]);
    widen(e.y(), &errors[kParts]);
    for (int i = 0; i < n_; ++i) {
      const Rows row = rows[static_cast<std::size_t>(i)];
      Lanes<double>* line = &jtj_[at(i, 0)];
      for (int j = 0; j <= i; ++j) line[j] += product(row, rows[static_cast<std::size_t>(j)]);
      jte_[static_cast<std::size_t>(i)] += product(row, errors);
    }
  }

  // The sums over all lanes.
  void total(NormalEquations& out) const {
    for (int i = 0; i < n_; ++i) {
      out.jte[i] = jte_[static_cast<std::size_t>(i)].sum();
      for (int j = 0; j <= i; ++j) out.jtj(j, i) = jtj_[at(i, j)].sum();
    }
  }

 private:
  static constexpr std::size_t kParts = sizeof(double) / sizeof(typename LaneOf<T>::Type);
  using Rows = std::array<Lanes<double>, 2 * kParts>;

  [[nodiscard]] static constexpr std::size_t at(int i, int j) { return static_cast<std::size_t>(i * (i + 1) / 2 + j); }
  [[nodiscard, gnu::always_inline]] static Lanes<double> product(const Rows& a, const Rows& b) {
    Lanes<double> sum = a[0] * b[0];
    for (std::size_t k = 1; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
  }

  int n_ = 0;
  std::array<Lanes<double>, kMaxParameters*(kMaxParameters + 1) / 2> jtj_;  // line by line of the lower triangle
  std::array<Lanes<double>, kMaxParameters> jte_;
};

}  // namespace srd::dsp
