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

[[nodiscard]] int coarse_step(const PatternProblem& problem) {
  return std::max(1, static_cast<int>(problem.square_px() / kCoarsePixels));
}

}  // namespace

Result<PatternEstimator> PatternEstimator::make(const View<double>& view, const Region& region, const PatternSurface& surface,
                                                const Media<double>& media, const CheckerPlane& plane,
                                                const PatternOptions& options) {
  constexpr int kMinSide = 8;
  if (region.u1 - region.u0 < kMinSide || region.v1 - region.v0 < kMinSide) return Errc::kInvalidArgument;
  if (surface.parameters() < 1 || surface.parameters() >= kMaxModes) return Errc::kInvalidArgument;
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
  return PatternEstimator(PatternProblem(view, region, surface, media, plane, options.gradients), options);
}

int PatternEstimator::choose_start(std::span<const Coefficients<double>> starts, double& explained) {
  int chosen = -1;
  NormalEquations sums;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (starts[i].size() != problem_.surface().parameters() || !starts[i].allFinite()) continue;
    if (!problem_.start_from(starts[i])) continue;
    problem_.hold_blur(kCoarse.front() * problem_.square_px());
    problem_.thin(coarse_step(problem_));
    if (!problem_.evaluate(starts[i], sums) || !sums.finite()) continue;
    const double here = 1 - sums.cost / problem_.squares_without_pattern();
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
    if (!problem_.start_from(a)) return Stop::kOutOfDomain;
    problem_.hold_blur(blur * problem_.square_px());
    problem_.thin(coarse_step(problem_));
    const GaussNewtonSummary done = DampedGaussNewton(problem_, solver).minimise(a, sums);
    out.surface.iterations += done.iterations;
    if (failed(done.stop)) return done.stop;
  }
  Coefficients<double> unknowns(n + 1);
  bool at_bound = false;
  unknowns[n] = kFirstBlur * problem_.square_px();
  problem_.free_blur();
  problem_.thin(1);
  const bool defaults = options_.epsg <= 0 && options_.epsf <= 0 && options_.epsx <= 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    if (!problem_.start_from(a)) return Stop::kOutOfDomain;
    unknowns.head(n) = a;
    if (solver.scale.size() == n) {
      solver.scale.conservativeResize(n + 1);
      solver.scale[n] = 1;
    }
    solver.lower = Coefficients<double>::Constant(n + 1, -std::numeric_limits<double>::infinity());
    solver.upper = -solver.lower;
    solver.lower[n] = kMinBlur;
    solver.upper[n] = kMaxBlurSquares * problem_.square_px();
    if (pass == kPasses - 1) {
      solver.epsg = defaults ? kDefaultTolerance : options_.epsg;
      solver.epsf = defaults ? kDefaultTolerance : options_.epsf;
      solver.epsx = defaults ? kDefaultTolerance : options_.epsx;
      solver.max_iterations = options_.max_iterations == 0 ? kDefaultIterations : options_.max_iterations;
    }
    const GaussNewtonSummary done = DampedGaussNewton(problem_, solver).minimise(unknowns, sums);
    out.surface.iterations += done.iterations;
    out.surface.stop = done.stop;
    at_bound = done.at_bound;
    if (failed(done.stop)) return done.stop;
    a = unknowns.head(n);
    if (pass == kPasses - 1) break;
    if (!problem_.evaluate(unknowns, sums)) return Stop::kNonFinite;
    problem_.reweigh();
  }

  // The last trial may have been refused: what follows is of the result.
  if (!problem_.evaluate(unknowns, sums)) return Stop::kNonFinite;
  out.blur_px = unknowns[n];
  out.levels = problem_.levels();
  const double pixels = problem_.n_pixels();
  out.surface.coefficients = a;
  out.surface.cost = sums.cost;
  out.surface.corners_used = problem_.n_pixels();
  out.surface.mean_error = sums.error / pixels;
  out.surface.variance_factor = sums.squares / (pixels - sums.n - problem_.n_levels());
  out.surface.at_bound = at_bound;
  out.explained = 1 - sums.squares / problem_.squares_without_pattern();

  const int block_px = std::max(1, static_cast<int>(std::lround(kBlockSquares * problem_.square_px())));
  PatternProblem::Sandwich parts;
  problem_.sandwich(block_px, parts);
  const double freedom = parts.blocks - sums.n;
  if (!(freedom > 0)) return Stop::kTooFewCorners;
  parts.middle *= parts.blocks / freedom;
  Uncertainty uncertainty;
  if (!uncertainty_of(parts.bread, &parts.middle, 1, static_cast<int>(n), uncertainty)) return Stop::kSingular;
  // The blur was estimated too; of the covariance its row and column are left out.
  ScaledCholesky factors;
  if (!factors.factor(uncertainty.information)) return Stop::kSingular;
  const InformationMatrix<double> covariance = factors.inverse().topLeftCorner(n, n);
  if (!factors.factor(covariance)) return Stop::kSingular;
  out.surface.information = factors.inverse();
  out.surface.standard_deviation = covariance.diagonal().cwiseSqrt();
  return out.surface.stop;
}

PatternEstimate PatternEstimator::estimate(const GrayView& image, std::span<const std::uint8_t> mask,
                                           std::span<const Coefficients<double>> starts) {
  PatternEstimate out;
  out.pixels = problem_.load(image, mask);
  const int unknowns = problem_.surface().parameters() + 1 + problem_.n_levels();
  if (out.pixels < kPixelsPerUnknown * unknowns) return out;
  // Less than the rounding of grey levels: an even image.
  if (!(problem_.squares_without_pattern() > out.pixels / 12.0)) {
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
