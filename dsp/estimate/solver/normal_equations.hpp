// SPDX-License-Identifier: Apache-2.0
// Sums of a least-squares problem, J'WJ and J'We.
#pragma once

#include <cmath>

#include "dsp/estimate/solver/information.hpp"

namespace srd::dsp {

// As the solver takes them.
struct NormalEquations {
  Eigen::Matrix<double, kMaxParameters, kMaxParameters> jtj;  // upper triangle of the first n x n
  Eigen::Matrix<double, kMaxParameters, 1> jte;
  double cost = 0;            // sum of |We|^2
  double cost_noise = 0;      // how much of it may be rounding
  double gradient_noise = 0;  // what a step promises when nothing but rounding is left in J'We
  double error = 0;           // sum of |e|
  double squares = 0;         // sum of |e|^2
  int n = 0;

  void reset(int parameters) {
    n = parameters;
    jtj.topLeftCorner(n, n).setZero();
    jte.head(n).setZero();
    cost = cost_noise = gradient_noise = error = squares = 0;
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
