// Sums of a least-squares problem, J'WJ and J'We, in double whatever the scalar of the residuals: a float sum of 552
// products would spend the digits that nearly dependent modes need.
#pragma once

#include "dsp/estimate/reprojection_residual.hpp"

namespace srd::dsp {

template <class S>
using InformationMatrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxModes, kMaxModes>;

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
    cost = 0;
    cost_noise = 0;
    error = 0;
    squares = 0;
  }

  // Adds one corner's two rows, de/da_j = by_height phi_j + by_slope grad phi_j.
  template <class S>
  void add(const CornerResidual<S>& residual, const Basis<S>& basis, S weight) {
    std::array<double, kMaxModes> row0, row1;
    const Vec2<S> h = weight * residual.by_height;
    const Mat2<S> g = weight * residual.by_slope;
    const double e0 = static_cast<double>(weight * residual.e.x());
    const double e1 = static_cast<double>(weight * residual.e.y());
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      row0[at] = static_cast<double>(h.x() * basis.value[i] + g(0, 0) * basis.dx[i] + g(0, 1) * basis.dy[i]);
      row1[at] = static_cast<double>(h.y() * basis.value[i] + g(1, 0) * basis.dx[i] + g(1, 1) * basis.dy[i]);
    }
    for (int i = 0; i < n; ++i) {
      const double r0 = row0[static_cast<std::size_t>(i)], r1 = row1[static_cast<std::size_t>(i)];
      double* column = jtj.data() + i * kMaxModes;
      for (int j = 0; j <= i; ++j)
        column[j] += r0 * row0[static_cast<std::size_t>(j)] + r1 * row1[static_cast<std::size_t>(j)];
      jte[i] += r0 * e0 + r1 * e1;
    }
    cost += e0 * e0 + e1 * e1;
    const double square = static_cast<double>(residual.e.squaredNorm());
    error += std::sqrt(square);
    squares += square;
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

}  // namespace srd::dsp
