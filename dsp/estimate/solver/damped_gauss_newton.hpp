// SPDX-License-Identifier: Apache-2.0
// Least squares with box bounds: Gauss-Newton, damped by Nielsen's gain ratio (H. B. Nielsen, Damping parameter in
// Marquardt's method, IMM-REP-1999-05). Optics (15). No heap; the sums, the damping and the steps are double.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/estimate/solver/cholesky.hpp"
#include "dsp/estimate/solver/gauss_newton_options.hpp"
#include "dsp/estimate/solver/stop.hpp"

namespace srd::dsp {

struct GaussNewtonSummary {
  Stop stop = Stop::kOutOfDomain;
  int iterations = 0;  // trial points evaluated, refused ones too
  bool at_bound = false;
  bool refused = false;  // the last trial point: the problem was evaluated elsewhere since
};

// Problem: bool evaluate(const Coefficients<double>& a, NormalEquations& sums); false where the residuals do not exist.
// a: start and result; sums: at the result, or a last short step before it (kStep, kCost), unless failed. A trial point that
// is outside the domain, not finite, or dearer than the rounding of the cost explains, is refused and the damping grows.
template <class Problem>
class DampedGaussNewton {
 public:
  DampedGaussNewton(Problem& problem, const GaussNewtonOptions& options) : problem_(problem), options_(options) {}

  [[nodiscard]] GaussNewtonSummary minimise(Coefficients<double>& a, NormalEquations& sums) {
    GaussNewtonSummary out;
    clamp(a);
    if (!a.allFinite()) {
      out.stop = Stop::kNonFinite;
      return out;
    }
    if (!problem_.evaluate(a, sums)) return out;
    if (!sums.finite()) {
      out.stop = Stop::kNonFinite;
      return out;
    }
    double damping = 0, growth = 2;
    bool drowned = false;  // the last step promised no more than rounding
    for (;;) {
      out.stop = Stop::kGradient;
      if (options_.epsg > 0 && gradient_size(a, sums) <= options_.epsg) break;
      out.stop = Stop::kNoProgress;
      if (drowned) break;
      out.stop = Stop::kMaxIterations;
      if (options_.max_iterations > 0 && out.iterations >= options_.max_iterations) break;
      out.stop = Stop::kDeadline;
      if (options_.deadline != nullptr && options_.deadline(options_.deadline_context)) break;

      out.stop = Stop::kNoProgress;
      const double promised = step(a, sums, damping) ? promised_fall(sums) : -std::numeric_limits<double>::infinity();
      // No factor, or a step bent by the box so far that the model itself sees the cost rise.
      if (promised < -sums.cost_noise) {
        if (!grow(damping, growth)) break;
        continue;
      }
      if (damping <= kUndamped) {
        out.stop = Stop::kStep;
        bool last = options_.epsx > 0 && scaled_size() <= options_.epsx;
        if (!last) {
          out.stop = Stop::kCost;
          last = options_.epsf > 0 && promised <= options_.epsf * sums.cost + sums.gradient_noise;
        }
        if (last) {
          // So short a step is as the linear model says: it is taken, and not evaluated.
          a += step_;
          clamp(a);
          sums.cost -= std::clamp(promised, 0.0, sums.cost);
          break;
        }
      }
      trial_ = a + step_;
      clamp(trial_);
      ++out.iterations;
      const bool exists = problem_.evaluate(trial_, trial_sums_) && trial_sums_.finite();
      out.refused = !exists || !(trial_sums_.cost <= sums.cost + sums.cost_noise);
      if (out.refused) {
        out.stop = Stop::kNoProgress;
        if (promised <= sums.cost_noise || !grow(damping, growth)) break;
        continue;
      }
      drowned = promised <= sums.cost_noise;
      const double gain = promised > 0 ? (sums.cost - trial_sums_.cost) / promised : 1;
      const double wide = 2 * std::clamp(gain, 0.0, 1.0) - 1;
      if (gain < kPoorGain && !drowned) damping = std::max(damping, kFirstDamping);
      damping *= std::max(kBestShrink, 1 - wide * wide * wide);
      if (damping < kUndamped / 100) damping = 0;
      growth = 2;
      a = trial_;
      std::swap(sums, trial_sums_);
    }
    out.at_bound = at_bound(a);
    return out;
  }

 private:
  static constexpr double kUndamped = 1e-3;  // of the diagonal: the step is Gauss-Newton's own
  static constexpr double kFirstDamping = 1e-3;
  static constexpr double kPoorGain = 0.25;  // fall / promised: below, the linear model is trusted less
  static constexpr double kBestShrink = 0.1;
  static constexpr double kMaxDamping = 1e12;

  [[nodiscard]] static bool grow(double& damping, double& growth) {
    damping = std::max(damping, kFirstDamping) * growth;
    growth *= 2;
    return damping <= kMaxDamping;
  }

  void clamp(Coefficients<double>& a) const {
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      if (options_.lower.size() > 0) a[i] = std::max(a[i], options_.lower[i]);
      if (options_.upper.size() > 0) a[i] = std::min(a[i], options_.upper[i]);
    }
  }
  [[nodiscard]] bool at_lower(const Coefficients<double>& a, Eigen::Index i) const {
    return options_.lower.size() > 0 && a[i] <= options_.lower[i];
  }
  [[nodiscard]] bool at_upper(const Coefficients<double>& a, Eigen::Index i) const {
    return options_.upper.size() > 0 && a[i] >= options_.upper[i];
  }
  [[nodiscard]] bool at_bound(const Coefficients<double>& a) const {
    for (Eigen::Index i = 0; i < a.size(); ++i)
      // Equal bounds hold a coefficient on purpose: that is no sign of trouble.
      if (at_lower(a, i) != at_upper(a, i)) return true;
    return false;
  }
  // A bound holds coefficient i when going downhill would leave the box.
  [[nodiscard]] bool held(const Coefficients<double>& a, const NormalEquations& sums, Eigen::Index i) const {
    return (at_lower(a, i) && sums.jte[i] > 0) || (at_upper(a, i) && sums.jte[i] < 0);
  }
  [[nodiscard]] double scale(Eigen::Index i) const { return options_.scale.size() > 0 ? options_.scale[i] : 1.0; }

  [[nodiscard]] double gradient_size(const Coefficients<double>& a, const NormalEquations& sums) const {
    double most = 0;
    for (Eigen::Index i = 0; i < a.size(); ++i)
      if (!held(a, sums, i)) most = std::max(most, std::abs(scale(i) * sums.jte[i]));
    return most;
  }

  [[nodiscard]] double scaled_size() const {
    double sum = 0;
    for (Eigen::Index i = 0; i < step_.size(); ++i) sum += step_[i] * step_[i] / (scale(i) * scale(i));
    return std::sqrt(sum);
  }

  [[nodiscard]] double promised_fall(const NormalEquations& sums) const {
    const Eigen::Index n = step_.size();
    return -step_.dot(2 * sums.jte.head(n) + matrix_.lazyProduct(step_));
  }

  // The damped step over the free coefficients; one that would leave the box is put on its bound and the rest solved
  // again. False: the matrix has no positive definite factor at this damping.
  [[nodiscard]] bool step(const Coefficients<double>& a, const NormalEquations& sums, double damping) {
    const Eigen::Index n = a.size();
    matrix_ = sums.matrix();
    step_ = Coefficients<double>::Zero(n);
    std::array<bool, kMaxParameters> fixed{};
    Eigen::Index free = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      fixed[static_cast<std::size_t>(i)] = held(a, sums, i);
      if (!fixed[static_cast<std::size_t>(i)]) ++free;
    }
    double largest = 0;  // with given scales damping is D^-2 of the scaled matrix's largest diagonal entry
    for (Eigen::Index i = 0; i < n; ++i) largest = std::max(largest, matrix_(i, i) * scale(i) * scale(i));
    while (free > 0) {
      InformationMatrix<double> reduced(free, free);
      Coefficients<double> downhill(free);
      Eigen::Index row = 0;
      for (Eigen::Index i = 0; i < n; ++i) {
        if (fixed[static_cast<std::size_t>(i)]) continue;
        downhill[row] = -sums.jte[i];
        Eigen::Index column = 0;
        for (Eigen::Index j = 0; j < n; ++j) {
          if (fixed[static_cast<std::size_t>(j)])
            downhill[row] -= matrix_(i, j) * step_[j];
          else
            reduced(row, column++) = matrix_(i, j);
        }
        reduced(row, row) += damping * (options_.scale.size() > 0 ? largest / (scale(i) * scale(i)) : matrix_(i, i));
        ++row;
      }
      if (!factors_.factor(reduced) || !(factors_.smallest_pivot() > 0)) return false;
      const Coefficients<double> solved = factors_.solve(downhill);
      if (!solved.allFinite()) return false;
      bool inside = true;
      row = 0;
      for (Eigen::Index i = 0; i < n; ++i) {
        bool& at = fixed[static_cast<std::size_t>(i)];
        if (at) continue;
        step_[i] = solved[row++];
        const bool below = options_.lower.size() > 0 && a[i] + step_[i] < options_.lower[i];
        const bool above = options_.upper.size() > 0 && a[i] + step_[i] > options_.upper[i];
        if (!below && !above) continue;
        step_[i] = (below ? options_.lower[i] : options_.upper[i]) - a[i];
        at = true;
        inside = false;
        --free;
      }
      if (inside) break;
    }
    return true;
  }

  Problem& problem_;
  const GaussNewtonOptions& options_;
  InformationMatrix<double> matrix_;
  Coefficients<double> step_, trial_;
  NormalEquations trial_sums_;
  ScaledCholesky factors_;
};

}  // namespace srd::dsp
