// Sums of a least-squares problem, J'WJ and J'We.
#pragma once

#include <array>
#include <cmath>

#include "dsp/estimate/corner_residual.hpp"
#include "dsp/estimate/information.hpp"

namespace srd::dsp {

// As the solver takes them.
struct NormalEquations {
  Eigen::Matrix<double, kMaxModes, kMaxModes> jtj;  // upper triangle of the first n x n
  Eigen::Matrix<double, kMaxModes, 1> jte;
  double cost = 0;        // sum of |We|^2
  double cost_noise = 0;  // how much of it may be rounding
  double error = 0;       // sum of |e|
  double squares = 0;     // sum of |e|^2
  int n = 0;

  void reset(int parameters) {
    n = parameters;
    jtj.topLeftCorner(n, n).setZero();
    jte.head(n).setZero();
    cost = cost_noise = error = squares = 0;
  }

  [[nodiscard]] bool finite() const {
    double sum = cost;
    for (int i = 0; i < n; ++i) sum += jte[i] + jtj(i, i);
    return std::isfinite(sum);
  }

  // The whole matrix, both triangles.
  [[nodiscard]] InformationMatrix<double> matrix() const {
    InformationMatrix<double> full = jtj.topLeftCorner(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) full(j, i) = full(i, j);
    return full;
  }
};

// Collects J'WJ and J'We lane by lane, and moves them on into double every kLongest corners of a lane: in float the
// rounding of 32 products stays below 1e-6 of the matrix, a tenth of what the rank is judged by.
template <class T>
class NormalSums {
 public:
  // The sums go to out.
  explicit NormalSums(NormalEquations& out) : out_(out), n_(out.n) { clear(); }

  // Adds the two rows of a corner, de/da_j = by_height phi_j + by_slope grad phi_j.
  void add(const CornerResidual<T>& residual, const Basis<T>& basis, T weight) {
    if (added_ == kLongest) flush();
    ++added_;
    std::array<T, kMaxModes> row0, row1;
    const Vec2<T> h = residual.by_height * weight, e = residual.e * weight;
    const Mat2<T> g = residual.by_slope * weight;
    for (int i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      row0[k] = h.x() * basis.value[i] + g(0, 0) * basis.dx[i] + g(0, 1) * basis.dy[i];
      row1[k] = h.y() * basis.value[i] + g(1, 0) * basis.dx[i] + g(1, 1) * basis.dy[i];
    }
    for (int i = 0; i < n_; ++i) {
      const T r0 = row0[static_cast<std::size_t>(i)], r1 = row1[static_cast<std::size_t>(i)];
      T* line = &jtj_[at(i, 0)];
      for (int j = 0; j <= i; ++j)
        line[j] += r0 * row0[static_cast<std::size_t>(j)] + r1 * row1[static_cast<std::size_t>(j)];
      jte_[static_cast<std::size_t>(i)] += r0 * e.x() + r1 * e.y();
    }
  }

  // After the last corner.
  void flush() {
    for (int i = 0; i < n_; ++i) {
      out_.jte[i] += jte_[static_cast<std::size_t>(i)].sum();
      for (int j = 0; j <= i; ++j) out_.jtj(j, i) += jtj_[at(i, j)].sum();
    }
    clear();
  }

 private:
  static constexpr int kLongest = 16;

  [[nodiscard]] static constexpr std::size_t at(int i, int j) { return static_cast<std::size_t>(i * (i + 1) / 2 + j); }
  void clear() {
    added_ = 0;
    for (int i = 0; i < n_; ++i) {
      jte_[static_cast<std::size_t>(i)] = 0;
      for (int j = 0; j <= i; ++j) jtj_[at(i, j)] = 0;
    }
  }

  NormalEquations& out_;
  int n_ = 0, added_ = 0;
  std::array<T, kMaxModes*(kMaxModes + 1) / 2> jtj_;  // line by line of the lower triangle
  std::array<T, kMaxModes> jte_;
};

}  // namespace srd::dsp
