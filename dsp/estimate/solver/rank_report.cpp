// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/solver/rank_report.hpp"

#include <algorithm>
#include <cmath>

namespace srd::dsp {
namespace {

using Places = std::array<std::uint8_t, kMaxParameters>;

// The factor of the parameters taken so far; rows for all.
struct Factor {
  InformationMatrix<double> l;
  Places taken{};
  int rank = 0;

  [[nodiscard]] Eigen::Index row(int step) const { return taken[static_cast<std::size_t>(step)]; }
};

// Writes a parameter as a combination x of those taken, L' x = its row.
void explain(const Factor& factor, int parameter, double pivot, Dependence& out) {
  out = {};
  out.parameter = parameter;
  out.pivot = std::max(pivot, 0.0);
  std::array<double, kMaxParameters> share{};
  const auto size = [&](int step) { return std::abs(share[static_cast<std::size_t>(step)]); };
  double largest = 0;
  for (int i = factor.rank - 1; i >= 0; --i) {
    double sum = factor.l(parameter, i);
    for (int j = i + 1; j < factor.rank; ++j) sum -= factor.l(factor.row(j), i) * share[static_cast<std::size_t>(j)];
    share[static_cast<std::size_t>(i)] = sum / factor.l(factor.row(i), i);
    largest = std::max(largest, size(i));
  }
  Places steps{};
  for (int i = 0; i < factor.rank; ++i)
    if (largest > 0 && size(i) >= largest / 10) steps[static_cast<std::size_t>(out.n_others++)] = static_cast<std::uint8_t>(i);
  std::sort(steps.begin(), steps.begin() + out.n_others, [&](int a, int b) { return size(a) > size(b); });
  for (std::size_t i = 0; i < static_cast<std::size_t>(out.n_others); ++i) out.others[i] = factor.taken[steps[i]];
}

// Takes the parameters in the order of their pivots, those from the place modes on last, and hands out each one's pivot
// and the factor so far before it is taken.
template <class Visit>
int factorise(const InformationMatrix<double>& a, int modes, Visit visit) {
  const int n = static_cast<int>(a.rows());
  std::array<double, kMaxParameters> scale{}, left{};
  std::array<bool, kMaxParameters> remaining{};
  for (int i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool any = a(i, i) > 0 && std::isfinite(a(i, i));
    scale[at] = any ? 1 / std::sqrt(a(i, i)) : 0;
    left[at] = any ? 1 : 0;
    remaining[at] = true;
  }
  Factor factor;
  factor.l = InformationMatrix<double>::Zero(n, n);
  for (int turn = 0; turn < n; ++turn) {
    int best = -1;
    for (int i = 0; i < n; ++i) {
      if (!remaining[static_cast<std::size_t>(i)]) continue;
      // Of equals, which rounding must not tell apart, the first.
      if (best < 0 || (i < modes && left[static_cast<std::size_t>(i)] > left[static_cast<std::size_t>(best)] + 1e-9)) best = i;
    }
    const double pivot = left[static_cast<std::size_t>(best)];
    remaining[static_cast<std::size_t>(best)] = false;
    visit(factor, best, pivot);
    if (!(pivot > kRankThreshold)) continue;
    const int step = factor.rank;
    const double root = std::sqrt(pivot);
    factor.l(best, step) = root;
    for (int i = 0; i < n; ++i) {
      if (!remaining[static_cast<std::size_t>(i)]) continue;
      double sum = a(i, best) * scale[static_cast<std::size_t>(i)] * scale[static_cast<std::size_t>(best)];
      for (int k = 0; k < step; ++k) sum -= factor.l(i, k) * factor.l(best, k);
      factor.l(i, step) = sum / root;
      left[static_cast<std::size_t>(i)] -= factor.l(i, step) * factor.l(i, step);
    }
    factor.taken[static_cast<std::size_t>(factor.rank++)] = static_cast<std::uint8_t>(best);
  }
  return factor.rank;
}

}  // namespace

void find_dependences(const InformationMatrix<double>& a, int modes, RankReport& out) {
  out.parameters = static_cast<int>(a.rows());
  out.n_dependences = 0;
  out.rank = factorise(a, modes, [&](const Factor& factor, int parameter, double pivot) {
    if (!(pivot > kNearlyDependent))
      explain(factor, parameter, pivot, out.dependences[static_cast<std::size_t>(out.n_dependences++)]);
  });
}

Dependence dependence_of_last(const InformationMatrix<double>& a) {
  const int last = static_cast<int>(a.rows()) - 1;
  Dependence out;
  (void)factorise(a, last, [&](const Factor& factor, int parameter, double pivot) {
    if (parameter == last) explain(factor, parameter, pivot, out);
  });
  return out;
}

}  // namespace srd::dsp
