// SPDX-License-Identifier: Apache-2.0
#include "proto/information.hpp"

#include <algorithm>
#include <cmath>

namespace srd::proto {
namespace {

constexpr double kMaxEntry = 32767;

}  // namespace

template <class S>
bool quantise(const dsp::InformationMatrix<S>& information, InformationFactor& factor) {
  factor = InformationFactor{};
  const auto n = static_cast<int>(information.rows());
  if (n == 0 || information.cols() != n) return false;
  std::array<double, kMaxFactorEntries> u;
  const auto at = &InformationFactor::index;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i <= j; ++i) {
      double sum = static_cast<double>(information(i, j));
      for (int k = 0; k < i; ++k) sum -= u[at(k, i)] * u[at(k, j)];
      if (i < j) {
        u[at(i, j)] = sum / u[at(i, i)];
      } else {
        if (!(sum > 0) || !std::isfinite(sum)) return false;
        u[at(j, j)] = std::sqrt(sum);
      }
    }
    double most = 0;
    for (int i = 0; i <= j; ++i) {
      if (!std::isfinite(u[at(i, j)])) return false;
      most = std::max(most, std::abs(u[at(i, j)]));
    }
    // The diagonal entry, on which the deviations depend most, is a whole number of steps: it comes back exactly.
    const double steps = std::floor(u[at(j, j)] / most * kMaxEntry);
    const auto scale = static_cast<float>(u[at(j, j)] / steps);
    if (steps < 1 || !std::isnormal(scale)) return false;
    factor.scale[static_cast<std::size_t>(j)] = scale;
    for (int i = 0; i <= j; ++i)
      factor.entries[at(i, j)] =
          static_cast<std::int16_t>(std::clamp(std::round(u[at(i, j)] / static_cast<double>(scale)), -kMaxEntry, kMaxEntry));
  }
  factor.size = n;
  return true;
}

template bool quantise<float>(const dsp::InformationMatrix<float>&, InformationFactor&);
template bool quantise<double>(const dsp::InformationMatrix<double>&, InformationFactor&);

dsp::InformationMatrix<double> expand(const InformationFactor& factor) {
  dsp::InformationMatrix<double> u(factor.size, factor.size);
  u.setZero();
  for (int j = 0; j < factor.size; ++j)
    for (int i = 0; i <= j; ++i)
      u(i, j) = static_cast<double>(factor.scale[static_cast<std::size_t>(j)]) * factor.entries[InformationFactor::index(i, j)];
  return u;
}

dsp::Coefficients<double> standard_deviations(const InformationFactor& factor) {
  const dsp::InformationMatrix<double> u = expand(factor);
  const int n = factor.size;
  dsp::Coefficients<double> deviation(n);
  // Column by column of U^-1; the variance of coefficient i is the squared length of row i.
  deviation.setZero();
  for (int column = 0; column < n; ++column) {
    dsp::Coefficients<double> x(n);
    x.setZero();
    x[column] = 1 / u(column, column);
    for (int i = column - 1; i >= 0; --i) {
      double sum = 0;
      for (int k = i + 1; k <= column; ++k) sum -= u(i, k) * x[k];
      x[i] = sum / u(i, i);
    }
    for (int i = 0; i <= column; ++i) deviation[i] += x[i] * x[i];
  }
  for (int i = 0; i < n; ++i) deviation[i] = std::sqrt(deviation[i]);
  return deviation;
}

}  // namespace srd::proto
