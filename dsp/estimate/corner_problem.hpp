// The corners of a frame as the solver's least-squares problem.
#pragma once

#include <limits>
#include <span>

#include "dsp/estimate/covariance.hpp"
#include "dsp/estimate/metric.hpp"
#include "dsp/estimate/ray_residual.hpp"
#include "dsp/estimate/reprojection_residual.hpp"

namespace srd::dsp {

// Residuals of a finished fit in raw pixels, exact for reprojection, else in the one-step form of (11).
struct PixelErrors {
  double squares = 0;           // px^2
  double weighted_squares = 0;  // in units of sigma
  NormalEquations middle;       // of the sandwich (17); not for reprojection
};

// S: scalar. Corners come in groups that fill the lanes; lanes without a corner repeat one with weight 0.
template <class S>
class CornerProblem {
 public:
  using T = Lanes<S>;

  // corners: how many the groups hold.
  CornerProblem(Metric metric, const Optics<T>& optics, std::span<PreparedCorner<T>> groups, std::size_t corners)
      : metric_(metric), optics_(optics), groups_(groups), n_corners_(corners) {}

  // False: some corner has no residual on this surface.
  [[nodiscard]] bool evaluate(const Coefficients<double>& coefficients, NormalEquations& out) {
    const Coefficients<T> a = in_lanes(coefficients);
    out.reset(static_cast<int>(a.size()));
    NormalSums<T> sums(out.n);
    for (PreparedCorner<T>& group : groups_) {
      CornerResidual<T> term;
      if (!residual(a, group, &basis_, term, nullptr)) return false;
      if (metric_ == Metric::kReprojection) group.pixel_error = term.e;
      sums.add(term, basis_, group.weight);
      add_errors(term.e, group.weight, out);
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
    const int constant = optics_.model.modes.index_of(Mode{});
    const Vec3<T>& middle = groups_[groups_.size() / 2].point;
    const T level = constant >= 0 ? T(a[constant]) : optics_.model.height(in_lanes(a), middle.x(), middle.y());
    noise2_ = 0;
    for (PreparedCorner<T>& group : groups_) {
      start_at_level(T(level[0]), group);
      const T noise = rounding(group) * group.weight;
      noise2_ += (noise * noise).sum();
    }
  }

  // Cost of at most kSampledCorners corners, spread over all; NaN where it does not exist.
  [[nodiscard]] double sampled_cost(const Coefficients<S>& coefficients) {
    constexpr std::size_t kGroups = kSampledCorners / T::kSize;
    const Coefficients<T> a = in_lanes(coefficients);
    const std::size_t stride = (groups_.size() + kGroups - 1) / kGroups;
    NormalEquations sums;
    for (std::size_t i = 0; i < groups_.size(); i += stride) {
      CornerResidual<T> term;
      Basis<T>* const no_derivatives = nullptr;
      if (!residual(a, groups_[i], no_derivatives, term, nullptr)) return std::numeric_limits<double>::quiet_NaN();
      add_errors(term.e, groups_[i].weight, sums);
    }
    return sums.cost;
  }

  // sums: of the same coefficients.
  [[nodiscard]] bool pixel_errors(const Coefficients<double>& coefficients, const NormalEquations& sums,
                                  PixelErrors& out) {
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
      middle.add(pushed(term, e_q), basis_, group.weight);
    }
    middle.total(out.middle);
    out.squares = pixels.squares;
    out.weighted_squares = pixels.cost;
    return true;
  }

 private:
  static constexpr std::size_t kSampledCorners = 24;  // enough to tell surfaces apart

  template <class Number>
  [[nodiscard]] static Coefficients<T> in_lanes(const Coefficients<Number>& a) {
    Coefficients<T> out(a.size());
    for (Eigen::Index i = 0; i < a.size(); ++i) out[i] = T(a[i]);
    return out;
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

  [[nodiscard]] bool residual(const Coefficients<T>& a, PreparedCorner<T>& group, Basis<T>* modes,
                              CornerResidual<T>& out, Mat2<T>* e_pixel) const {
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
  const Optics<T>& optics_;
  std::span<PreparedCorner<T>> groups_;
  std::size_t n_corners_;
  double noise2_ = 0;
  Basis<T> basis_{};
};

}  // namespace srd::dsp
