// SPDX-License-Identifier: Apache-2.0
// Sums of the normal equations over corners, several at once.
#pragma once

#include <array>

#include "dsp/core/lanes.hpp"
#include "dsp/estimate/residual/corner_residual.hpp"
#include "dsp/estimate/solver/normal_equations.hpp"

namespace srd::dsp {

// Collects J'WJ and J'We over the lanes. Products are summed over kGroups groups in the lanes' own number, and from there on
// in double: pivots of nearly dependent modes are differences of these sums, and float sums over a whole frame would leave
// none of their digits. Sixteen terms of rounding 6e-8 each are well below the 1e-6 that float derivatives have.
template <class T>
class NormalSums {
 public:
  explicit NormalSums(int parameters) : n_(parameters) {
    for (int i = 0; i < n_; ++i) {
      jte_[static_cast<std::size_t>(i)].parts.fill(0);
      for (int j = 0; j <= i; ++j) jtj_[at(i, j)].parts.fill(0);
    }
  }

  // Adds the two rows of a corner, de/da_j = by_height phi_j + by_slope grad phi_j; a parameter beyond the modes is the
  // index of water.
  [[gnu::always_inline]] void add(const CornerResidual<T>& residual, const Basis<T>& basis, T weight) {
    const std::size_t x = 2 * filled_, y = x + 1;
    const int modes = static_cast<int>(basis.value.size());
    if (modes < n_) {
      rows_[static_cast<std::size_t>(modes)][x] = residual.by_index.x() * weight;
      rows_[static_cast<std::size_t>(modes)][y] = residual.by_index.y() * weight;
    }
    const Vec2<T> h = residual.by_height * weight;
    const Mat2<T> g = residual.by_slope * weight;
    for (int i = 0; i < modes; ++i) {
      Row& row = rows_[static_cast<std::size_t>(i)];
      row[x] = h.x() * basis.value[i] + g(0, 0) * basis.dx[i] + g(0, 1) * basis.dy[i];
      row[y] = h.y() * basis.value[i] + g(1, 0) * basis.dx[i] + g(1, 1) * basis.dy[i];
    }
    errors_[x] = residual.e.x() * weight;
    errors_[y] = residual.e.y() * weight;
    if (++filled_ == kGroups) flush();
  }

  // The sums over all lanes.
  void total(NormalEquations& out) {
    for (std::size_t k = 2 * filled_; filled_ > 0 && k < 2 * kGroups; ++k) {
      for (int i = 0; i < n_; ++i) rows_[static_cast<std::size_t>(i)][k] = 0;
      errors_[k] = 0;
    }
    if (filled_ > 0) flush();
    for (int i = 0; i < n_; ++i) {
      out.jte[i] = jte_[static_cast<std::size_t>(i)].sum();
      for (int j = 0; j <= i; ++j) out.jtj(j, i) = jtj_[at(i, j)].sum();
    }
  }

 private:
  static constexpr std::size_t kGroups = 8;
  static constexpr std::size_t kParts = sizeof(double) / sizeof(typename LaneOf<T>::Type);
  using Row = std::array<T, 2 * kGroups>;
  struct Sum {
    std::array<Lanes<double>, kParts> parts;

    void operator+=(T more) {
      std::array<Lanes<double>, kParts> wide;
      widen(more, wide.data());
      for (std::size_t k = 0; k < kParts; ++k) parts[k] += wide[k];
    }
    [[nodiscard]] double sum() const {
      Lanes<double> all = parts[0];
      for (std::size_t k = 1; k < kParts; ++k) all += parts[k];
      return all.sum();
    }
  };

  [[nodiscard]] static constexpr std::size_t at(int i, int j) { return static_cast<std::size_t>(i * (i + 1) / 2 + j); }
  [[nodiscard, gnu::always_inline]] static T product(const Row& a, const Row& b) {
    T even = a[0] * b[0], odd = a[1] * b[1];
    for (std::size_t k = 2; k < a.size(); k += 2) {
      even += a[k] * b[k];
      odd += a[k + 1] * b[k + 1];
    }
    return even + odd;
  }

  [[gnu::noinline]] void flush() {
    for (int i = 0; i < n_; ++i) {
      const Row row = rows_[static_cast<std::size_t>(i)];
      Sum* line = &jtj_[at(i, 0)];
      for (int j = 0; j <= i; ++j) line[j] += product(row, rows_[static_cast<std::size_t>(j)]);
      jte_[static_cast<std::size_t>(i)] += product(row, errors_);
    }
    filled_ = 0;
  }

  int n_ = 0;
  std::size_t filled_ = 0;  // groups in rows_
  std::array<Row, kMaxParameters> rows_;
  Row errors_;
  std::array<Sum, kMaxParameters*(kMaxParameters + 1) / 2> jtj_;  // line by line of the lower triangle
  std::array<Sum, kMaxParameters> jte_;
};

}  // namespace srd::dsp
