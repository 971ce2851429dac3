#include "dsp/estimate/estimator.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/estimate/covariance.hpp"
#include "dsp/estimate/ray_residual.hpp"

namespace srd::dsp {
namespace {

constexpr int kDefaultIterations = 50;
constexpr double kDefaultTolerance = 1e-9;
// Starts are compared on at most this many corners, spread over all: enough to tell surfaces apart.
constexpr std::size_t kStartCorners = 48;

[[nodiscard]] bool valid_bounds(const EstimatorOptions& options, std::size_t n) {
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

[[nodiscard]] Coefficients<double> as_coefficients(const std::vector<double>& list) {
  Coefficients<double> out(static_cast<Eigen::Index>(list.size()));
  std::copy(list.begin(), list.end(), out.data());
  return out;
}

}  // namespace

template <class S>
Result<SurfaceEstimator<S>> SurfaceEstimator<S>::make(const SurfaceModel<S>& model, const Media<S>& media,
                                                      std::span<const Vec3<S>> bottom_points,
                                                      const EstimatorOptions& options, int max_corners) {
  if (!valid_optics(model, media) || !valid_bounds(options, static_cast<std::size_t>(model.modes.size())))
    return Errc::kInvalidArgument;
  if (bottom_points.empty() || max_corners <= 0) return Errc::kInvalidArgument;
  for (const Vec3<S>& point : bottom_points)
    if (!point.allFinite()) return Errc::kInvalidArgument;
  SurfaceEstimator out;
  out.model_ = model;
  out.media_ = media;
  out.metric_ = options.metric;
  const bool all_off = options.epsg <= 0 && options.epsf <= 0 && options.epsx <= 0 && options.max_iterations == 0;
  out.solver_.epsg = all_off ? kDefaultTolerance : options.epsg;
  out.solver_.epsf = all_off ? kDefaultTolerance : options.epsf;
  out.solver_.epsx = all_off ? kDefaultTolerance : options.epsx;
  out.solver_.max_iterations = options.max_iterations == 0 ? kDefaultIterations : options.max_iterations;
  out.solver_.scale = as_coefficients(options.scale);
  out.solver_.lower = as_coefficients(options.lower);
  out.solver_.upper = as_coefficients(options.upper);
  out.solver_.deadline = options.deadline;
  out.solver_.deadline_context = options.deadline_context;
  out.points_.assign(bottom_points.begin(), bottom_points.end());
  out.corners_.resize(static_cast<std::size_t>(max_corners));
  return out;
}

template <class S>
struct SurfaceEstimator<S>::Problem {
  Optics<S> optics;
  std::span<PreparedCorner<S>> corners;
  Metric metric;
  Basis<S> basis{};

  [[nodiscard]] bool residual(const Coefficients<S>& a, PreparedCorner<S>& corner, Basis<S>* modes,
                              CornerResidual<S>& out, Mat2<S>* pixel_e = nullptr) {
    switch (metric) {
      case Metric::kReprojection: return reprojection_residual(optics, a, corner, modes, out);
      case Metric::kDisparity: return ray_residual(RayMetric::kDisparity, optics, a, corner, modes, out, pixel_e);
      case Metric::kCollinearity:
        return ray_residual(RayMetric::kCollinearity, optics, a, corner, modes, out, pixel_e);
    }
    return false;
  }

  // Rounding of one residual component, in the metric's unit: what a cost difference cannot resolve.
  [[nodiscard]] double rounding(const PreparedCorner<S>& corner) const {
    const double eps = static_cast<double>(std::numeric_limits<S>::epsilon());
    switch (metric) {
      case Metric::kReprojection: return 2 * eps * static_cast<double>(corner.pixel.cwiseAbs().maxCoeff() + 1);
      case Metric::kDisparity: return 2 * eps * static_cast<double>(corner.dry.norm() + std::abs(corner.along));
      case Metric::kCollinearity: return 8 * eps;
    }
    return 0;
  }

  [[nodiscard]] bool evaluate(const Coefficients<double>& coefficients, NormalEquations& sums) {
    const Coefficients<S> a = coefficients.template cast<S>();
    sums.reset(static_cast<int>(a.size()));
    double noise2 = 0;
    for (PreparedCorner<S>& corner : corners) {
      CornerResidual<S> term;
      if (!residual(a, corner, &basis, term)) return false;
      sums.add(term, basis, corner.weight);
      const double noise = rounding(corner) * static_cast<double>(corner.weight);
      noise2 += noise * noise;
    }
    const double mean_noise2 = noise2 / static_cast<double>(corners.size());
    sums.cost_noise = 3 * (std::sqrt(sums.cost * mean_noise2) + noise2) +
                      16 * std::numeric_limits<double>::epsilon() * sums.cost;
    return true;
  }

  // Cost on at most kStartCorners corners; NaN where it does not exist.
  [[nodiscard]] double sampled_cost(const Coefficients<S>& a) {
    const std::size_t stride = (corners.size() + kStartCorners - 1) / kStartCorners;
    double cost = 0;
    for (std::size_t i = 0; i < corners.size(); i += stride) {
      CornerResidual<S> term;
      if (!residual(a, corners[i], nullptr, term)) return std::numeric_limits<double>::quiet_NaN();
      cost += static_cast<double>((corners[i].weight * term.e).squaredNorm());
    }
    return cost;
  }
};

template <class S>
Stop SurfaceEstimator<S>::prepare_corners(std::span<const CameraObservations<S>> cameras) {
  n_corners_ = 0;
  for (const CameraObservations<S>& camera : cameras) {
    if (camera.corners.empty()) continue;
    if (camera.view == nullptr) return Stop::kInvalidInput;
    const Mat3<double> rotation = camera.view->pose.rotation.template cast<double>();
    const Vec3<double> centre = -(rotation.transpose() * camera.view->pose.translation.template cast<double>());
    if (!centre.allFinite()) return Stop::kNonFinite;
    for (const Observation<S>& seen : camera.corners) {
      if (!seen.pixel.allFinite() || !seen.normalised.allFinite() || !std::isfinite(seen.sigma))
        return Stop::kNonFinite;
      if (seen.point < 0 || static_cast<std::size_t>(seen.point) >= points_.size() || !(seen.sigma > 0) ||
          n_corners_ == corners_.size())
        return Stop::kInvalidInput;
      if (!prepare(seen, points_[static_cast<std::size_t>(seen.point)], *camera.view, centre, rotation,
                   corners_[n_corners_]))
        return Stop::kOutOfDomain;
      ++n_corners_;
    }
  }
  return 2 * n_corners_ < static_cast<std::size_t>(model_.modes.size()) ? Stop::kTooFewCorners : Stop::kGradient;
}

template <class S>
Stop SurfaceEstimator<S>::choose_start(std::span<const Coefficients<S>> starts, Problem& problem, int& chosen) {
  chosen = -1;
  bool finite = false;
  double least = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (starts[i].size() != model_.modes.size()) return Stop::kInvalidInput;
    if (!starts[i].allFinite()) continue;
    finite = true;
    for (PreparedCorner<S>& corner : problem.corners) start_at_level(model_, starts[i], corner);
    const double cost = problem.sampled_cost(starts[i]);
    if (!std::isfinite(cost) || (chosen >= 0 && !(cost < least))) continue;
    chosen = static_cast<int>(i);
    least = cost;
  }
  if (starts.empty()) return Stop::kInvalidInput;
  if (!finite) return Stop::kNonFinite;
  if (chosen < 0) return Stop::kOutOfDomain;
  for (PreparedCorner<S>& corner : problem.corners)
    start_at_level(model_, starts[static_cast<std::size_t>(chosen)], corner);
  return Stop::kGradient;
}

template <class S>
Stop SurfaceEstimator<S>::finish(Problem& problem, const NormalEquations& sums, Estimate<S>& out) {
  const int n = sums.n;
  const Coefficients<S>& a = out.coefficients;
  Sandwich sandwich(n);
  double mean_error = 0, pixels2 = 0, weighted2 = 0;
  for (PreparedCorner<S>& corner : problem.corners) {
    CornerResidual<S> term;
    Mat2<S> pixel_e = -Mat2<S>::Identity();
    if (!problem.residual(a, corner, &problem.basis, term, &pixel_e)) return Stop::kNonFinite;
    mean_error += static_cast<double>(term.e.norm());
    const Mat2<double> e_q = pixel_e.template cast<double>();
    Mat2<double> q_e;
    if (!invert(e_q, q_e)) return Stop::kSingular;
    const Vec2<double> pixels = q_e * term.e.template cast<double>();
    const double weight = static_cast<double>(corner.weight);
    pixels2 += pixels.squaredNorm();
    weighted2 += weight * weight * pixels.squaredNorm();
    if (problem.metric != Metric::kReprojection) sandwich.add(term, problem.basis, weight, e_q);
  }
  const double corners = static_cast<double>(problem.corners.size());
  const double freedom = 2 * corners - n;
  const double factor = freedom > 0 ? weighted2 / freedom : 0;
  out.mean_error = static_cast<S>(mean_error / corners);
  out.reprojection_rms = static_cast<S>(std::sqrt(pixels2 / (2 * corners)));
  out.cost = static_cast<S>(sums.cost);
  out.variance_factor = static_cast<S>(factor);
  out.corners_used = static_cast<int>(problem.corners.size());

  // Exact features leave no residual to scale with; rounding of the pixels is then what is left.
  const double rounding = 1e3 * static_cast<double>(std::numeric_limits<S>::epsilon());
  const double s2 = freedom > 0 ? std::max(factor, rounding * rounding) : 1;
  Uncertainty uncertainty;
  if (!uncertainty_of(sums.matrix(), problem.metric == Metric::kReprojection ? nullptr : &sandwich, s2,
                      rank_threshold<S>(), uncertainty))
    return Stop::kSingular;
  out.information = uncertainty.information.template cast<S>();
  out.standard_deviation = uncertainty.standard_deviation.template cast<S>();
  return out.stop;
}

template <class S>
Estimate<S> SurfaceEstimator<S>::estimate(std::span<const CameraObservations<S>> cameras,
                                          std::span<const Coefficients<S>> starts) {
  Estimate<S> out;
  out.stop = prepare_corners(cameras);
  if (failed(out.stop)) return out;
  Problem problem{Optics<S>::make(model_, media_), std::span(corners_).first(n_corners_), metric_};
  out.stop = choose_start(starts, problem, out.start_used);
  if (failed(out.stop)) return out;

  Coefficients<double> a = starts[static_cast<std::size_t>(out.start_used)].template cast<double>();
  NormalEquations sums;
  DampedGaussNewton<Problem> solver(problem, solver_);
  const GaussNewtonSummary summary = solver.minimise(a, sums);
  out.stop = summary.stop;
  out.iterations = summary.iterations;
  out.at_bound = summary.at_bound;
  if (failed(out.stop)) return out;
  out.coefficients = a.template cast<S>();
  out.stop = finish(problem, sums, out);
  return out;
}

template class SurfaceEstimator<float>;
template class SurfaceEstimator<double>;

}  // namespace srd::dsp
