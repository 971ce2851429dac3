// SPDX-License-Identifier: Apache-2.0
// The members of SurfaceEstimator, which estimator_float.cpp and estimator_double.cpp compile side by side.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/estimate/estimator/corner_problem.hpp"
#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/estimate/solver/robust_fit.hpp"

namespace srd::dsp {

inline constexpr double kHeldDeviation = 1e-4;  // mm, stated for a coefficient that equal bounds hold

[[nodiscard]] inline bool valid_bounds(const EstimatorOptions& options, std::size_t n) {
  for (const std::vector<double>* list : {&options.scale, &options.lower, &options.upper}) {
    if (!list->empty() && list->size() != n) return false;
    for (const double x : *list)
      if (std::isnan(x)) return false;
  }
  for (const double x : options.scale)
    if (!(x > 0) || !std::isfinite(x)) return false;
  for (std::size_t i = 0; i < options.lower.size() && i < options.upper.size(); ++i)
    if (!(options.lower[i] <= options.upper[i])) return false;
  for (const double x : {options.epsg, options.epsf, options.epsx})
    if (!(x >= 0) || !std::isfinite(x)) return false;
  if (options.free_index && !(options.index_lower > 0.5 && options.index_lower <= options.index_upper &&
                              std::isfinite(options.index_upper) && options.index_most_deviation > 0))
    return false;
  return options.max_iterations >= 0;
}

template <class S>
[[nodiscard]] bool valid_optics(const SurfaceModel<S>& model, const Media<S>& media) {
  if (model.modes.size() == 0) return false;
  for (const S x : {model.lx, model.ly, media.air, media.water})
    if (!(x > 0) || !std::isfinite(x)) return false;
  if (!std::isfinite(model.x0) || !std::isfinite(model.y0)) return false;
  if (media.n_layers < 0 || media.n_layers > kMaxLayers) return false;
  for (int i = 0; i < media.n_layers; ++i) {
    const Layer<S>& layer = media.layers[static_cast<std::size_t>(i)];
    if (!(layer.thickness >= 0) || !(layer.index > 0) || !std::isfinite(layer.thickness + layer.index)) return false;
  }
  return true;
}

inline constexpr double kIndexScale = 0.01;  // of water, where coefficients have scales

// One more number for the index of water. others: of the coefficients where none are given; NaN: leave the
// list empty.
inline void append_parameter(double last, double others, Eigen::Index modes, Coefficients<double>& list) {
  if (list.size() == 0) {
    if (std::isnan(others)) return;
    list.setConstant(modes, others);
  }
  list.conservativeResize(modes + 1);
  list[modes] = last;
}

[[nodiscard]] inline Coefficients<double> as_coefficients(const std::vector<double>& list) {
  Coefficients<double> out(static_cast<Eigen::Index>(list.size()));
  std::copy(list.begin(), list.end(), out.data());
  return out;
}

template <class S>
Result<SurfaceEstimator<S>> SurfaceEstimator<S>::make(const SurfaceModel<S>& model, const Media<S>& media,
                                                      std::span<const Vec3<S>> bottom_points, const EstimatorOptions& options,
                                                      int max_corners) {
  if (!valid_optics(model, media) || !valid_bounds(options, static_cast<std::size_t>(model.modes.size())))
    return Errc::kInvalidArgument;
  if (bottom_points.empty() || max_corners <= 0) return Errc::kInvalidArgument;
  for (const Vec3<S>& point : bottom_points)
    if (!point.allFinite()) return Errc::kInvalidArgument;
  SurfaceEstimator out;
  out.model_ = model;
  out.media_ = media;
  out.metric_ = options.metric;
  out.loss_ = options.loss;
  const bool all_off = options.epsg <= 0 && options.epsf <= 0 && options.epsx <= 0 && options.max_iterations == 0;
  out.solver_.epsg = all_off ? EstimatorOptions::kDefaultEpsg : options.epsg;
  out.solver_.epsf = all_off ? EstimatorOptions::kDefaultEpsf : options.epsf;
  out.solver_.epsx = all_off ? EstimatorOptions::kDefaultEpsx : options.epsx;
  out.solver_.max_iterations = options.max_iterations == 0 ? EstimatorOptions::kDefaultMaxIterations : options.max_iterations;
  out.solver_.scale = as_coefficients(options.scale);
  out.solver_.lower = as_coefficients(options.lower);
  out.solver_.upper = as_coefficients(options.upper);
  const Eigen::Index modes = model.modes.size();
  if (options.free_index) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    append_parameter(kIndexScale, std::numeric_limits<double>::quiet_NaN(), modes, out.solver_.scale);
    append_parameter(options.index_lower, -kFar, modes, out.solver_.lower);
    append_parameter(options.index_upper, kFar, modes, out.solver_.upper);
    out.index_most_deviation_ = options.index_most_deviation;
  }
  out.solver_.deadline = options.deadline;
  out.solver_.deadline_context = options.deadline_context;
  out.points_.assign(bottom_points.begin(), bottom_points.end());
  out.height_products_ = InformationMatrix<double>::Zero(modes, modes);
  Basis<S> basis;
  for (const Vec3<S>& point : bottom_points) {
    model.basis(point.x(), point.y(), basis);
    const Coefficients<double> phi = basis.value.template cast<double>();
    out.height_products_ += phi * phi.transpose() / static_cast<double>(bottom_points.size());
  }
  out.optics_ = Optics<Lanes<S>>::make(model, media);
  out.optics_.free_index = options.free_index;
  out.max_corners_ = static_cast<std::size_t>(max_corners);
  out.sizes_.resize(out.max_corners_);
  out.groups_.resize(out.max_corners_ / Lanes<S>::kSize + kMaxCameras);
  return out;
}

template <class S>
Stop SurfaceEstimator<S>::prepare_corners(std::span<const CameraObservations<S>> cameras) {
  n_corners_ = n_groups_ = 0;
  // Along the measured ray the digits of the undistorted corner count. Reprojection takes the ray for a start only, and
  // does without where the corners know their feet.
  const bool refine = metric_ != Metric::kReprojection;
  rays_ = refine;
  for (const CameraObservations<S>& camera : cameras)
    for (const Observation<S>& seen : camera.corners) rays_ = rays_ || !seen.foot.allFinite();
  std::size_t n_cameras = 0;
  for (const CameraObservations<S>& camera : cameras) {
    if (camera.corners.empty()) continue;
    if (camera.view == nullptr || n_cameras == views_.size()) return Stop::kInvalidInput;
    if (camera.corners.size() > max_corners_ - n_corners_) return Stop::kInvalidInput;
    const WideView wide(*camera.view);
    if (!wide.rotation.allFinite() || !wide.centre.allFinite()) return Stop::kNonFinite;
    View<Lanes<S>>& view = views_[n_cameras++];
    view = camera.view->template cast<Lanes<S>>();
    int lane = Lanes<S>::kSize;
    PreparedCorner<S> corner;
    for (const Observation<S>& seen : camera.corners) {
      if (!seen.pixel.allFinite() || !seen.normalised.allFinite() || !std::isfinite(seen.sigma)) return Stop::kNonFinite;
      if (seen.point < 0 || static_cast<std::size_t>(seen.point) >= points_.size() || !(seen.sigma > 0))
        return Stop::kInvalidInput;
      if (!prepare(seen, points_[static_cast<std::size_t>(seen.point)], wide, corner)) return Stop::kOutOfDomain;
      if (rays_ && !prepare_ray(seen, wide, refine, corner)) return Stop::kOutOfDomain;
      if (lane == Lanes<S>::kSize) {
        groups_[n_groups_].view = &view;
        groups_[n_groups_++].trusted = 1;
        lane = 0;
      }
      put(corner, rays_, lane++, groups_[n_groups_ - 1]);
      ++n_corners_;
    }
    // Lanes that stay empty repeat the last corner without weight.
    corner.weight = 0;
    for (; lane < Lanes<S>::kSize; ++lane) put(corner, rays_, lane, groups_[n_groups_ - 1]);
  }
  return 2 * n_corners_ < static_cast<std::size_t>(parameters()) ? Stop::kTooFewCorners : Stop::kGradient;
}

template <class S>
Stop SurfaceEstimator<S>::choose_start(std::span<const Coefficients<S>> starts, CornerProblem<S>& problem, int& chosen) {
  chosen = -1;
  if (starts.empty()) return Stop::kInvalidInput;
  for (const Coefficients<S>& start : starts)
    if (start.size() != model_.modes.size()) return Stop::kInvalidInput;
  bool finite = false;
  double least = std::numeric_limits<double>::infinity();
  // The one that costs least on a few corners goes first: the others mostly cost more before all corners are looked at.
  std::size_t first = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (!starts[i].allFinite()) continue;
    finite = true;
    const double cost = starts.size() > 1 ? problem.sampled_cost(starts[i], least, true) : 0;
    if (!(cost < least)) continue;
    least = cost;
    first = i;
  }
  least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const std::size_t i = k == 0 ? first : k <= first ? k - 1 : k;
    if (!starts[i].allFinite()) continue;
    const double cost = starts.size() > 1 ? problem.sampled_cost(starts[i], least) : 0;
    if (!(cost < least)) continue;
    chosen = static_cast<int>(i);
    least = cost;
  }
  if (!finite) return Stop::kNonFinite;
  if (chosen < 0) return Stop::kOutOfDomain;
  problem.start_from(starts[static_cast<std::size_t>(chosen)]);
  return Stop::kGradient;
}

template <class S>
Stop SurfaceEstimator<S>::finish(CornerProblem<S>& problem, const Coefficients<double>& a, const NormalEquations& sums,
                                 Estimate<S>& out) {
  int held = 0;
  for (int i = 0; i < sums.n; ++i) held += is_held(i) ? 1 : 0;
  PixelErrors pixels;
  if (!problem.pixel_errors(a, sums, pixels)) return Stop::kNonFinite;
  const double corners = pixels.corners, freedom = 2 * corners - (sums.n - held);
  const double factor = freedom > 0 ? pixels.weighted_squares / freedom : 0;
  out.mean_error = static_cast<S>(pixels.error / corners);
  out.reprojection_rms = static_cast<S>(std::sqrt(pixels.squares / (2 * corners)));
  out.cost = static_cast<S>(sums.cost);
  out.variance_factor = static_cast<S>(factor);
  out.corners_used = static_cast<int>(corners);

  // Exact features leave no residual to scale with; rounding of the pixels is then what is left.
  const double rounding = 1e3 * static_cast<double>(std::numeric_limits<S>::epsilon());
  const double s2 = freedom > 0 ? std::max(factor, rounding * rounding) : 1;
  const bool sandwich = metric_ != Metric::kReprojection;
  InformationMatrix<double> middle;
  if (sandwich) middle = pixels.middle.matrix();
  InformationMatrix<double> h = loss_ == Loss::kNone ? sums.matrix() : pixels.plain.matrix();
  // A held coefficient is known: as by an observation of its own, so that the others' deviations do not pay
  // for it.
  for (int i = 0; i < sums.n; ++i)
    if (is_held(i)) {
      const double known = s2 / (kHeldDeviation * kHeldDeviation);
      h(i, i) += known;
      if (sandwich) middle(i, i) += known;
    }
  Uncertainty uncertainty;
  const int modes = model_.modes.size();
  const bool determined = uncertainty_of(h, sandwich ? &middle : nullptr, s2, modes, uncertainty);
  out.rank = uncertainty.rank;
  if (!determined) {
    // The index comes last: when it alone is missing, the coefficients without it are all right.
    const RankReport& rank = out.rank;
    const int last = rank.n_dependences - 1;
    const bool index_only = optics_.free_index && rank.rank == modes && last >= 0 &&
                            rank.dependences[static_cast<std::size_t>(last)].parameter == modes;
    return index_only ? Stop::kIndexUndetermined : Stop::kSingular;
  }
  if (optics_.free_index)
    if (const Stop stop = take_index(a, h, s2, uncertainty, out); failed(stop)) return stop;
  out.information = uncertainty.information.template cast<S>();
  out.standard_deviation = uncertainty.standard_deviation.template cast<S>();
  const double variance = uncertainty.covariance.topLeftCorner(modes, modes).cwiseProduct(height_products_).sum();
  out.height_deviation = static_cast<S>(std::sqrt(std::max(variance, 0.0)));
  return out.stop;
}

template <class S>
void SurfaceEstimator<S>::error_sizes(std::span<S> out) const {
  std::size_t next = 0;
  for (const PreparedCorner<Lanes<S>>& group : std::span(groups_).first(n_groups_))
    for (int lane = 0; lane < Lanes<S>::kSize; ++lane)
      if (group.weight[lane] > 0 && next < out.size()) out[next++] = group.pixel_error.norm()[lane] * group.weight[lane];
}

template <class S>
Stop SurfaceEstimator<S>::take_index(const Coefficients<double>& a, const InformationMatrix<double>& h, double s2,
                                     Uncertainty& uncertainty, Estimate<S>& out) const {
  const Eigen::Index modes = model_.modes.size();
  const double deviation = uncertainty.standard_deviation[modes];
  out.index = static_cast<S>(a[modes]);
  out.index_deviation = static_cast<S>(deviation);
  // Exact corners would determine anything: judged by what real ones could do.
  double sigma2 = 0;  // mean of the corners' own
  for (std::size_t i = 0; i < n_groups_; ++i)
    for (int lane = 0; lane < Lanes<S>::kSize; ++lane)
      if (const double weight = static_cast<double>(groups_[i].weight[lane]); weight > 0)
        sigma2 += 1 / (weight * weight * static_cast<double>(n_corners_));
  const double least_s2 = kMinScatterPx * kMinScatterPx / sigma2;
  const double judged = deviation * std::sqrt(std::max(1.0, least_s2 / s2));
  const Dependence dependence = dependence_of_last(h);
  if (!(dependence.pivot > kIndexPivot) || !(judged <= index_most_deviation_)) {
    if (dependence.pivot > kNearlyDependent)  // else it is there already
      out.rank.dependences[static_cast<std::size_t>(out.rank.n_dependences++)] = dependence;
    return Stop::kIndexUndetermined;
  }
  // What is known of the coefficients when the index is not.
  const InformationMatrix<double>& all = uncertainty.information;
  const Coefficients<double> shared = all.col(modes).head(modes);
  InformationMatrix<double> own = all.topLeftCorner(modes, modes);
  own -= shared.lazyProduct(shared.transpose()) / all(modes, modes);
  uncertainty.information = own;
  uncertainty.standard_deviation.conservativeResize(modes);
  return Stop::kGradient;
}

template <class S>
Estimate<S> SurfaceEstimator<S>::estimate(std::span<const CameraObservations<S>> cameras,
                                          std::span<const Coefficients<S>> starts, bool timed) {
  Estimate<S> out;
  out.index = media_.water;
  optics_.media.water = Lanes<S>(media_.water);
  out.stop = prepare_corners(cameras);
  if (failed(out.stop)) return out;
  const std::span<PreparedCorner<Lanes<S>>> groups = std::span(groups_).first(n_groups_);
  // Far from the surface the angle between normals falls again with the depth and leads to a wrong one; the
  // disparity difference does not. It chooses the start and brings the surface near.
  const bool approach = metric_ == Metric::kCollinearity;
  const std::span<double> sizes = std::span(sizes_).first(n_corners_);
  CornerProblem<S> near(approach ? Metric::kDisparity : metric_, optics_, groups, rays_, sizes);
  out.stop = choose_start(starts, near, out.start_used);
  if (failed(out.stop)) return out;

  Coefficients<double> a = starts[static_cast<std::size_t>(out.start_used)].template cast<double>();
  NormalEquations sums;
  if (optics_.free_index) {
    a.conservativeResize(a.size() + 1);
    a[a.size() - 1] = static_cast<double>(media_.water);
  }
  const auto limits = [&] {
    GaussNewtonOptions made = solver_;
    if (!timed) made.deadline = nullptr;
    return made;
  };
  GaussNewtonOptions options = limits();
  if (approach) {
    options.epsg = options.epsx = 0;
    options.epsf = kApproachFall;
    // Gross corners draw the surface deeper whatever the loss: those that Tukey's gives no weight here have none there.
    const GaussNewtonSummary summary = loss_ == Loss::kNone
                                           ? DampedGaussNewton<CornerProblem<S>>(near, options).minimise(a, sums)
                                           : fit_robustly(near, options, Loss::kTukey, a, sums);
    out.stop = summary.stop;
    out.iterations = summary.iterations;
    if (failed(out.stop)) return out;
    if (loss_ != Loss::kNone && !near.distrust_gross(a)) {
      out.stop = Stop::kOutOfDomain;
      return out;
    }
    options = limits();
    options.max_iterations = std::max(1, options.max_iterations - out.iterations);
  }
  CornerProblem<S> problem(metric_, optics_, groups, rays_, sizes);
  problem.start_from(a.template cast<S>());
  const GaussNewtonSummary summary = loss_ == Loss::kNone
                                         ? DampedGaussNewton<CornerProblem<S>>(problem, options).minimise(a, sums)
                                         : fit_robustly(problem, options, loss_, a, sums);
  out.stop = summary.stop;
  out.iterations += summary.iterations;
  out.at_bound = summary.at_bound;
  if (failed(out.stop)) return out;
  out.coefficients = a.head(model_.modes.size()).template cast<S>();
  // The corners' errors are those of the last evaluation.
  if (summary.refused && !problem.evaluate(a, sums)) {
    out.stop = Stop::kOutOfDomain;
    return out;
  }
  if (loss_ != Loss::kNone) out.loss_scale = static_cast<S>(problem.loss().scale);
  out.stop = finish(problem, a, sums, out);
  if (optics_.free_index && !failed(out.stop)) media_.water = out.index;
  return out;
}

}  // namespace srd::dsp
