// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/pattern_metric/pattern_estimator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dsp/estimate/estimator/covariance.hpp"
#include "dsp/estimate/solver/damped_gauss_newton.hpp"

namespace srd::dsp {
namespace {

constexpr double kDefaultTolerance = 1e-9;
constexpr int kDefaultIterations = 50;
constexpr int kPixelsPerUnknown = 10;
// Blur of the stages, in squares: the first makes the wave all but a sine, which leads over 0.4 squares; each next one
// is within reach of what the one before leaves.
constexpr std::array<double, 2> kCoarse{0.2, 0.07};
// The blurred wave is as well seen by so many pixels a side of a square.
constexpr double kCoarsePixels = 8;
constexpr double kApproach = 1e-4;  // promised fall of the cost at which a coarse stage ends
constexpr int kCoarseIterations = 30;
constexpr double kFirstBlur = 0.03;                       // squares; start of the unknown
constexpr double kMinBlur = 0.25, kMaxBlurSquares = 0.2;  // px; squares: bounds of the unknown
// Passes with the blur as an unknown. Each takes weights and the blur's footprint from where the one before ended.
constexpr int kPasses = 4;
constexpr double kBlockSquares = 0.5;  // side of a block of the sandwich

}  // namespace

Result<PatternEstimator> PatternEstimator::make(std::span<const PatternView> views, const PatternSurface& surface,
                                                const Media<double>& media, const CheckerPlane& plane,
                                                const PatternOptions& options) {
  constexpr int kMinSide = 8;
  if (views.empty() || views.size() > kMaxPatternViews) return Errc::kInvalidArgument;
  for (const PatternView& each : views)
    if (each.region.u1 - each.region.u0 < kMinSide || each.region.v1 - each.region.v0 < kMinSide) return Errc::kInvalidArgument;
  if (surface.parameters() < 1 || surface.parameters() + static_cast<int>(views.size()) > kMaxModes)
    return Errc::kInvalidArgument;
  for (const double x : {plane.square_mm, media.air, media.water})
    if (!(x > 0) || !std::isfinite(x)) return Errc::kInvalidArgument;
  if (surface.form == SurfaceForm::kModes && (!(surface.model.lx > 0) || !(surface.model.ly > 0)))
    return Errc::kInvalidArgument;
  for (const double x : {options.epsg, options.epsf, options.epsx})
    if (!(x >= 0) || !std::isfinite(x)) return Errc::kInvalidArgument;
  if (!options.scale.empty() && options.scale.size() != static_cast<std::size_t>(surface.parameters()))
    return Errc::kInvalidArgument;
  for (const double x : options.scale)
    if (!(x > 0) || !std::isfinite(x)) return Errc::kInvalidArgument;
  if (options.max_iterations < 0 || !std::isfinite(plane.x + plane.y + plane.z)) return Errc::kInvalidArgument;
  std::vector<PatternProblem> problems;
  problems.reserve(views.size());
  for (const PatternView& each : views) problems.emplace_back(each.view, each.region, surface, media, plane, options.gradients);
  return PatternEstimator(PatternViews(std::move(problems)), options);
}

int PatternEstimator::choose_start(std::span<const Coefficients<double>> starts, double& explained) {
  int chosen = -1;
  NormalEquations sums;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (starts[i].size() != views_.surface().parameters() || !starts[i].allFinite()) continue;
    if (!views_.start_from(starts[i])) continue;
    views_.hold_blur(kCoarse.front());
    views_.thin(kCoarsePixels);
    if (!views_.evaluate(starts[i], sums) || !sums.finite()) continue;
    const double here = 1 - sums.cost / views_.squares_without_pattern();
    if (chosen >= 0 && !(here > explained)) continue;
    chosen = static_cast<int>(i);
    explained = here;
  }
  return chosen;
}

Stop PatternEstimator::refine(Coefficients<double>& a, PatternEstimate& out) {
  GaussNewtonOptions solver;
  solver.epsf = kApproach;
  solver.max_iterations = kCoarseIterations;
  const Eigen::Index n = a.size();
  if (!options_.scale.empty()) solver.scale = Eigen::Map<const Eigen::VectorXd>(options_.scale.data(), n);
  NormalEquations sums;
  for (const double blur : kCoarse) {
    if (!views_.start_from(a)) return Stop::kOutOfDomain;
    views_.hold_blur(blur);
    views_.thin(kCoarsePixels);
    const GaussNewtonSummary done = DampedGaussNewton(views_, solver).minimise(a, sums);
    out.surface.iterations += done.iterations;
    if (failed(done.stop)) return done.stop;
  }
  const Eigen::Index blurs = views_.size();
  Coefficients<double> unknowns(n + blurs);
  bool at_bound = false;
  for (int i = 0; i < blurs; ++i) unknowns[n + i] = kFirstBlur * views_[i].square_px();
  views_.free_blur();
  views_.thin(0);
  const bool defaults = options_.epsg <= 0 && options_.epsf <= 0 && options_.epsx <= 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    if (!views_.start_from(a)) return Stop::kOutOfDomain;
    unknowns.head(n) = a;
    if (solver.scale.size() == n) {
      solver.scale.conservativeResize(n + blurs);
      solver.scale.tail(blurs).setOnes();
    }
    solver.lower = Coefficients<double>::Constant(n + blurs, -std::numeric_limits<double>::infinity());
    solver.upper = -solver.lower;
    solver.lower.tail(blurs).setConstant(kMinBlur);
    for (int i = 0; i < blurs; ++i) solver.upper[n + i] = kMaxBlurSquares * views_[i].square_px();
    if (pass == kPasses - 1) {
      solver.epsg = defaults ? kDefaultTolerance : options_.epsg;
      solver.epsf = defaults ? kDefaultTolerance : options_.epsf;
      solver.epsx = defaults ? kDefaultTolerance : options_.epsx;
      solver.max_iterations = options_.max_iterations == 0 ? kDefaultIterations : options_.max_iterations;
    }
    const GaussNewtonSummary done = DampedGaussNewton(views_, solver).minimise(unknowns, sums);
    out.surface.iterations += done.iterations;
    out.surface.stop = done.stop;
    at_bound = done.at_bound;
    if (failed(done.stop)) return done.stop;
    a = unknowns.head(n);
    if (pass == kPasses - 1) break;
    if (!views_.evaluate(unknowns, sums)) return Stop::kNonFinite;
    views_.reweigh();
  }

  // The last trial may have been refused: what follows is of the result.
  if (!views_.evaluate(unknowns, sums)) return Stop::kNonFinite;
  for (int i = 0; i < blurs; ++i) out.images[static_cast<std::size_t>(i)] = {unknowns[n + i], views_[i].levels()};
  const double pixels = views_.n_pixels();
  out.surface.coefficients = a;
  out.surface.cost = sums.cost;
  out.surface.corners_used = views_.n_pixels();
  out.surface.mean_error = sums.error / pixels;
  out.surface.variance_factor = sums.squares / (pixels - sums.n - views_.n_levels());
  out.surface.at_bound = at_bound;
  out.explained = 1 - sums.squares / views_.squares_without_pattern();

  PatternProblem::Sandwich parts;
  views_.sandwich(kBlockSquares, parts);
  const double freedom = parts.blocks - sums.n;
  if (!(freedom > 0)) return Stop::kTooFewCorners;
  parts.middle *= parts.blocks / freedom;
  Uncertainty uncertainty;
  if (!uncertainty_of(parts.bread, &parts.middle, 1, static_cast<int>(n), uncertainty)) return Stop::kSingular;
  // The blurs were estimated too; of the covariance their rows and columns are left out.
  ScaledCholesky factors;
  if (!factors.factor(uncertainty.information)) return Stop::kSingular;
  const InformationMatrix<double> covariance = factors.inverse().topLeftCorner(n, n);
  if (!factors.factor(covariance)) return Stop::kSingular;
  out.surface.information = factors.inverse();
  out.surface.standard_deviation = covariance.diagonal().cwiseSqrt();
  return out.surface.stop;
}

PatternEstimate PatternEstimator::estimate(std::span<const GrayView> images,
                                           std::span<const std::span<const std::uint8_t>> masks,
                                           std::span<const Coefficients<double>> starts) {
  PatternEstimate out;
  out.pixels = views_.load(images, masks);
  const int unknowns = views_.surface().parameters() + views_.size() + views_.n_levels();
  if (out.pixels < kPixelsPerUnknown * unknowns) return out;
  // Less than the rounding of grey levels: an even image.
  if (!(views_.squares_without_pattern() > out.pixels / 12.0)) {
    out.surface.stop = Stop::kOutOfDomain;
    return out;
  }
  double explained = 0;
  out.surface.start_used = choose_start(starts, explained);
  if (out.surface.start_used < 0) {
    out.surface.stop = Stop::kOutOfDomain;
    return out;
  }
  Coefficients<double> a = starts[static_cast<std::size_t>(out.surface.start_used)];
  out.surface.stop = refine(a, out);
  return out;
}

}  // namespace srd::dsp
