// SPDX-License-Identifier: Apache-2.0
// The corners of a frame as the solver's least-squares problem.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "dsp/estimate/estimator/covariance.hpp"
#include "dsp/estimate/estimator/normal_sums.hpp"
#include "dsp/estimate/residual/metric.hpp"
#include "dsp/estimate/residual/ray_residual.hpp"
#include "dsp/estimate/residual/reprojection_residual.hpp"
#include "dsp/estimate/solver/loss.hpp"

namespace srd::dsp {

// Residuals of a finished fit in raw pixels, exact for reprojection, else in the one-step form of (11). A corner that the
// loss gives no weight is not in any of these.
struct PixelErrors {
  double error = 0;             // sum of |e|, in the metric's unit
  double squares = 0;           // px^2
  double weighted_squares = 0;  // in units of sigma; with a loss, of psi over its mean derivative
  double corners = 0;
  NormalEquations plain;   // J'WJ; with a loss only
  NormalEquations middle;  // of the sandwich (17); not for reprojection
};

// S: scalar. Parameters are the coefficients, then the index of water when the optics say that it is free; the optics
// keep the index that was evaluated last. Corners come in groups that fill the lanes; lanes without a corner repeat one with weight 0.
template <class S>
class CornerProblem {
 public:
  using T = Lanes<S>;

  // rays: groups hold the measured rays; else their feet. sizes: workspace, as long as there are corners.
  CornerProblem(Metric metric, Optics<T>& optics, std::span<PreparedCorner<T>> groups, bool rays, std::span<double> sizes)
      : metric_(metric), optics_(optics), groups_(groups), rays_(rays), n_corners_(sizes.size()), sizes_(sizes) {}

  // False: some corner has no residual on this surface.
  [[nodiscard]] bool evaluate(const Coefficients<double>& coefficients, NormalEquations& out) {
    const Coefficients<T> a = in_lanes(coefficients);
    out.reset(static_cast<int>(coefficients.size()));
    NormalSums<T> sums(out.n);
    for (PreparedCorner<T>& group : groups_) {
      CornerResidual<T> term;
      if (!residual(a, group, &basis_, term, nullptr)) return false;
      if (metric_ == Metric::kReprojection) group.pixel_error = term.e;
      sums.add(term, basis_, loss_.kind == Loss::kNone ? group.weight : lessened(term.e, group, out));
      if (loss_.kind == Loss::kNone) add_errors(term.e, group.weight, out);
    }
    sums.total(out);
    out.gradient_noise = out.n * noise2_ / static_cast<double>(n_corners_);
    const double mean_noise2 = noise2_ / static_cast<double>(n_corners_);
    out.cost_noise = 3 * (std::sqrt(out.cost * mean_noise2) + noise2_) +
                     16 * static_cast<double>(std::numeric_limits<S>::epsilon()) * out.cost;
    return true;
  }

  // Forgets where the last evaluation ended.
  void start_from(const Coefficients<S>& a) {
    const T level = level_of(a);
    noise2_ = 0;
    for (PreparedCorner<T>& group : groups_) {
      start_at_level(level, rays_, group);
      const T noise = rounding(group) * group.weight;
      noise2_ += (noise * noise).sum();
    }
  }

  // Cost of at most kSampledCorners corners, spread over all, or of fewer that cost most already; NaN where it does not
  // exist. few: of one lane group. Start anew afterwards.
  [[nodiscard]] double sampled_cost(const Coefficients<S>& coefficients, double most, bool few = false) {
    constexpr std::size_t kGroups = kSampledCorners / T::kSize;
    const Coefficients<T> a = in_lanes(coefficients);
    const std::size_t stride = few ? groups_.size() : (groups_.size() + kGroups - 1) / kGroups;
    const T level = level_of(coefficients);
    NormalEquations sums;
    for (std::size_t i = 0; i < groups_.size() && sums.cost < most; i += stride) {
      start_at_level(level, rays_, groups_[i]);
      CornerResidual<T> term;
      Basis<T>* const no_derivatives = nullptr;
      if (!residual(a, groups_[i], no_derivatives, term, nullptr)) return std::numeric_limits<double>::quiet_NaN();
      add_errors(term.e, groups_[i].weight, sums);
    }
    return sums.cost;
  }

  // From here on, with the scale that the residuals at a have. False: they do not exist.
  [[nodiscard]] bool set_loss(Loss kind, const Coefficients<double>& coefficients) {
    const Coefficients<T> a = in_lanes(coefficients);
    auto size = sizes_.begin();
    for (PreparedCorner<T>& group : groups_) {
      CornerResidual<T> term;
      Basis<T>* const no_derivatives = nullptr;
      if (!residual(a, group, no_derivatives, term, nullptr)) return false;
      for (int lane = 0; lane < T::kSize; ++lane)
        if (counts(group, lane)) *size++ = std::sqrt(size2_of(term.e, group.weight, lane));
    }
    const auto middle = sizes_.begin() + (size - sizes_.begin()) / 2;
    std::nth_element(sizes_.begin(), middle, size);
    // Exact corners have no scatter but rounding.
    const double least = 4 * std::sqrt(noise2_ / static_cast<double>(n_corners_));
    loss_ = {kind, std::max(*middle / ScaledLoss::kMedianSize, least)};
    return std::isfinite(loss_.scale) && loss_.scale > 0;
  }
  [[nodiscard]] const ScaledLoss& loss() const { return loss_; }

  // Corners to which the loss gives no weight at a count no longer, in this problem or another on the same groups. False:
  // the residuals do not exist.
  [[nodiscard]] bool distrust_gross(const Coefficients<double>& coefficients) {
    const Coefficients<T> a = in_lanes(coefficients);
    for (PreparedCorner<T>& group : groups_) {
      CornerResidual<T> term;
      Basis<T>* const no_derivatives = nullptr;
      if (!residual(a, group, no_derivatives, term, nullptr)) return false;
      for (int lane = 0; lane < T::kSize; ++lane)
        if (!(loss_.at(size2_of(term.e, group.weight, lane)).weight > 0)) group.trusted.set(lane, 0);
    }
    return true;
  }

  // sums: of the same coefficients.
  [[nodiscard]] bool pixel_errors(const Coefficients<double>& coefficients, const NormalEquations& sums, PixelErrors& out) {
    if (loss_.kind != Loss::kNone) return robust_pixel_errors(coefficients, sums.n, out);
    out.error = sums.error;
    out.corners = static_cast<double>(n_corners_);
    if (metric_ == Metric::kReprojection) {
      out.squares = sums.squares;
      out.weighted_squares = sums.cost;
      return true;
    }
    const Coefficients<T> a = in_lanes(coefficients);
    out.middle.reset(sums.n);
    NormalSums<T> middle(sums.n);
    NormalEquations pixels;
    for (PreparedCorner<T>& group : groups_) {
      CornerResidual<T> term;
      Mat2<T> e_q, q_e;
      if (!residual(a, group, &basis_, term, &e_q) || !invert(e_q, q_e)) return false;
      group.pixel_error = q_e * term.e;
      add_errors(group.pixel_error, group.weight, pixels);
      middle.add(pushed(term, e_q, optics_.free_index), basis_, group.weight);
    }
    middle.total(out.middle);
    out.squares = pixels.squares;
    out.weighted_squares = pixels.cost;
    return true;
  }

 private:
  static constexpr std::size_t kSampledCorners = 24;  // enough to tell surfaces apart

  template <class Number>
  [[nodiscard]] Coefficients<T> in_lanes(const Coefficients<Number>& a) {
    const Eigen::Index modes = optics_.model.modes.size();
    if (optics_.free_index && a.size() > modes) optics_.media.water = T(a[modes]);
    Coefficients<T> out(modes);
    for (Eigen::Index i = 0; i < modes; ++i) out[i] = T(a[i]);
    return out;
  }

  [[nodiscard]] static bool counts(const PreparedCorner<T>& group, int lane) {
    return group.weight[lane] > 0 && group.trusted[lane] > 0;
  }

  // Of the constant mode, or the surface in the middle of the corners.
  [[nodiscard]] T level_of(const Coefficients<S>& a) {
    const int constant = optics_.model.modes.index_of(Mode{});
    if (constant >= 0) return T(a[constant]);
    const Vec3<T>& middle = groups_[groups_.size() / 2].point;
    return T(optics_.model.height(in_lanes(a), middle.x(), middle.y())[0]);
  }

  static void add_errors(const Vec2<T>& e, const T& weight, NormalEquations& out) {
    const T square = e.x() * e.x() + e.y() * e.y();
    const T size = sqrt(square), weighted = square * weight * weight;
    for (int lane = 0; lane < T::kSize; ++lane) {
      if (!(weight[lane] > 0)) continue;
      out.cost += static_cast<double>(weighted[lane]);
      out.error += static_cast<double>(size[lane]);
      out.squares += static_cast<double>(square[lane]);
    }
  }

  [[nodiscard]] static double size2_of(const Vec2<T>& e, const T& weight, int lane) {
    const double x = static_cast<double>(e.x()[lane] * weight[lane]), y = static_cast<double>(e.y()[lane] * weight[lane]);
    return x * x + y * y;
  }

  // The weights of a step with the loss; counts the cost.
  [[nodiscard]] T lessened(const Vec2<T>& e, const PreparedCorner<T>& group, NormalEquations& out) const {
    T less = 0;
    for (int lane = 0; lane < T::kSize; ++lane) {
      if (!counts(group, lane)) continue;
      const ScaledLoss::Value value = loss_.at(size2_of(e, group.weight, lane));
      out.cost += value.rho;
      less.set(lane, group.weight[lane] * static_cast<S>(std::sqrt(value.weight)));
    }
    return less;
  }

  // M-estimator: corners scatter as psi does, over its mean derivative (P. J. Huber, Robust Statistics, 1981, 7.6).
  [[nodiscard]] bool robust_pixel_errors(const Coefficients<double>& coefficients, int parameters, PixelErrors& out) {
    const Coefficients<T> a = in_lanes(coefficients);
    out.plain.reset(parameters);
    out.middle.reset(parameters);
    NormalSums<T> plain(parameters), middle(parameters);
    double psi2 = 0, derivative = 0;
    for (PreparedCorner<T>& group : groups_) {
      CornerResidual<T> term;
      Mat2<T> e_q, q_e;
      const bool ray = metric_ != Metric::kReprojection;
      if (!residual(a, group, &basis_, term, ray ? &e_q : nullptr)) return false;
      if (ray && !invert(e_q, q_e)) return false;
      const Vec2<T> pixels = ray ? Vec2<T>(q_e * term.e) : term.e;
      group.pixel_error = pixels;
      T weight = 0;
      for (int lane = 0; lane < T::kSize; ++lane) {
        if (!counts(group, lane)) continue;
        const double e2 = size2_of(term.e, T(1), lane), px2 = size2_of(pixels, T(1), lane);
        const double sigma = 1 / static_cast<double>(group.weight[lane]);
        const ScaledLoss::Value value = loss_.at(e2 / (sigma * sigma));
        if (!(value.weight > 0)) continue;
        weight.set(lane, group.weight[lane]);
        out.corners += 1;
        out.error += std::sqrt(e2);
        out.squares += px2;
        psi2 += value.weight * value.weight * px2 / (sigma * sigma);
        derivative += (value.weight + value.derivative) / 2;  // mean over the directions of a residual
      }
      plain.add(term, basis_, weight);
      if (ray) middle.add(pushed(term, e_q, optics_.free_index), basis_, weight);
    }
    plain.total(out.plain);
    middle.total(out.middle);
    const double mean = derivative / out.corners;
    out.weighted_squares = psi2 / (mean * mean);
    return mean > 0;
  }

  [[nodiscard]] bool residual(const Coefficients<T>& a, PreparedCorner<T>& group, Basis<T>* modes, CornerResidual<T>& out,
                              Mat2<T>* e_pixel) const {
    if (metric_ == Metric::kReprojection) return reprojection_residual(optics_, a, group, modes, out);
    return ray_residual(metric_, optics_, a, group, modes, out, e_pixel);
  }

  // Rounding of one residual component, in the metric's unit: what a difference of costs cannot resolve.
  [[nodiscard]] T rounding(const PreparedCorner<T>& group) const {
    const T epsilon = std::numeric_limits<S>::epsilon();
    switch (metric_) {
      case Metric::kReprojection: return 2 * epsilon * (abs(group.pixel.x()) + abs(group.pixel.y()) + 1);
      case Metric::kDisparity: return 2 * epsilon * (abs(group.dry.x()) + abs(group.dry.y()) + abs(group.along));
      case Metric::kCollinearity: return 8 * epsilon;
    }
    return 0;
  }

  Metric metric_;
  Optics<T>& optics_;
  std::span<PreparedCorner<T>> groups_;
  bool rays_;
  std::size_t n_corners_;
  std::span<double> sizes_;
  ScaledLoss loss_{};
  double noise2_ = 0;
  Basis<T> basis_{};
};

}  // namespace srd::dsp
