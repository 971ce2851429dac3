// The corners of a frame as the solver's least-squares problem.
#pragma once

#include <limits>
#include <span>

#include "dsp/estimate/covariance.hpp"
#include "dsp/estimate/metric.hpp"
#include "dsp/estimate/ray_residual.hpp"

namespace srd::dsp {

// Residuals of a finished fit in raw pixels, exact for reprojection, else in the one-step form of (11).
struct PixelErrors {
  explicit PixelErrors(int parameters) : sandwich(parameters) {}
  double squares = 0;           // px^2
  double weighted_squares = 0;  // in units of sigma
  Sandwich sandwich;            // not for reprojection
};

template <class S>
class CornerProblem {
 public:
  CornerProblem(Metric metric, const Optics<S>& optics, std::span<PreparedCorner<S>> corners)
      : metric_(metric), optics_(optics), corners_(corners) {}

  [[nodiscard]] std::size_t size() const { return corners_.size(); }

  // False: some corner has no residual on this surface.
  [[nodiscard]] bool evaluate(const Coefficients<double>& coefficients, NormalEquations& sums) {
    const Coefficients<S> a = coefficients.template cast<S>();
    sums.reset(static_cast<int>(a.size()));
    double noise2 = 0;
    for (PreparedCorner<S>& corner : corners_) {
      CornerResidual<S> term;
      if (!residual(a, corner, &basis_, term, nullptr)) return false;
      sums.add(term, basis_, corner.weight);
      const double noise = static_cast<double>(rounding(corner) * corner.weight);
      noise2 += noise * noise;
    }
    const double mean_noise2 = noise2 / static_cast<double>(corners_.size());
    sums.cost_noise = 3 * (std::sqrt(sums.cost * mean_noise2) + noise2) +
                      16 * std::numeric_limits<double>::epsilon() * sums.cost;
    return true;
  }

  // Forgets where the last evaluation ended.
  void start_from(const Coefficients<S>& a) {
    const int constant = optics_.model->modes.index_of(Mode{});
    const Vec3<S>& middle = corners_[corners_.size() / 2].point;
    const S level = constant >= 0 ? a[constant] : optics_.model->height(a, middle.x(), middle.y());
    for (PreparedCorner<S>& corner : corners_) start_at_level(level, corner);
  }

  // Cost on at most kSampledCorners corners, spread over all; NaN where it does not exist.
  [[nodiscard]] double sampled_cost(const Coefficients<S>& a) {
    const std::size_t stride = (corners_.size() + kSampledCorners - 1) / kSampledCorners;
    double cost = 0;
    for (std::size_t i = 0; i < corners_.size(); i += stride) {
      CornerResidual<S> term;
      if (!residual(a, corners_[i], nullptr, term, nullptr)) return std::numeric_limits<double>::quiet_NaN();
      cost += static_cast<double>((corners_[i].weight * term.e).squaredNorm());
    }
    return cost;
  }

  // sums: of the same coefficients.
  [[nodiscard]] bool pixel_errors(const Coefficients<S>& a, const NormalEquations& sums, PixelErrors& out) {
    if (metric_ == Metric::kReprojection) {
      out.squares = sums.squares;
      out.weighted_squares = sums.cost;
      return true;
    }
    for (PreparedCorner<S>& corner : corners_) {
      CornerResidual<S> term;
      Mat2<S> e_pixel;
      if (!residual(a, corner, &basis_, term, &e_pixel)) return false;
      const Mat2<double> e_q = e_pixel.template cast<double>();
      Mat2<double> q_e;
      if (!invert(e_q, q_e)) return false;
      const double weight = static_cast<double>(corner.weight);
      const double square = (q_e * term.e.template cast<double>()).squaredNorm();
      out.squares += square;
      out.weighted_squares += weight * weight * square;
      out.sandwich.add(term, basis_, weight, e_q);
    }
    return true;
  }

 private:
  static constexpr std::size_t kSampledCorners = 48;  // enough to tell surfaces apart

  [[nodiscard]] bool residual(const Coefficients<S>& a, PreparedCorner<S>& corner, Basis<S>* modes,
                              CornerResidual<S>& out, Mat2<S>* e_pixel) {
    if (metric_ == Metric::kReprojection) return reprojection_residual(optics_, a, corner, modes, out);
    return ray_residual(metric_, optics_, a, corner, modes, out, e_pixel);
  }

  // Rounding of one residual component, in the metric's unit: what a difference of costs cannot resolve.
  [[nodiscard]] S rounding(const PreparedCorner<S>& corner) const {
    constexpr S kEpsilon = std::numeric_limits<S>::epsilon();
    switch (metric_) {
      case Metric::kReprojection: return 2 * kEpsilon * (corner.pixel.cwiseAbs().maxCoeff() + 1);
      case Metric::kDisparity: return 2 * kEpsilon * (corner.dry.norm() + std::abs(corner.along));
      case Metric::kCollinearity: return 8 * kEpsilon;
    }
    return 0;
  }

  Metric metric_;
  Optics<S> optics_;
  std::span<PreparedCorner<S>> corners_;
  Basis<S> basis_{};
};

}  // namespace srd::dsp
