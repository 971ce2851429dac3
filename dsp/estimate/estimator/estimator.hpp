// SPDX-License-Identifier: Apache-2.0
// Surface coefficients from corners of one to many cameras: damped Gauss-Newton with analytic derivatives.
// Optics (9)-(11), (13)-(17). Everything is sized at construction; estimate() does not allocate, throw or read a clock
// except through the deadline callback. One thread per object.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/core/result.hpp"
#include "dsp/estimate/estimator/estimate.hpp"
#include "dsp/estimate/residual/metric.hpp"
#include "dsp/estimate/residual/observation.hpp"
#include "dsp/estimate/residual/prepared_corner.hpp"
#include "dsp/estimate/solver/gauss_newton_options.hpp"
#include "dsp/estimate/solver/information.hpp"
#include "dsp/estimate/solver/loss.hpp"
#include "dsp/estimate/solver/rank_report.hpp"
#include "dsp/estimate/solver/stop.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd::dsp {

template <class S>
class CornerProblem;
struct NormalEquations;
struct Uncertainty;

inline constexpr int kMaxCameras = 16;  // in one fit

struct EstimatorOptions {
  Metric metric = Metric::kReprojection;
  Loss loss = Loss::kNone;  // rho; its scale comes from the median of the frame's own residuals
  // A step that promises a fall of the cost by 1e-3 moves each of 12 coefficients by a fifth of its deviation where 552
  // residuals are. It is taken; what it leaves is smaller by the part that its own length bends the residuals, a thousandth
  // and less, and not worth another evaluation of all corners. Exact corners go on, since their cost falls to nothing. With
  // a loss the weights follow the step, and may leave a third of it.
  static constexpr double kDefaultEpsg = 1e-9, kDefaultEpsf = 1e-3, kDefaultEpsx = 1e-9;
  static constexpr int kDefaultMaxIterations = 50;
  // 0: that rule is off. All three and max_iterations 0, as in a file that names none: the defaults.
  double epsg = 0;
  double epsf = 0;
  double epsx = 0;
  int max_iterations = 0;     // 0: 50
  std::vector<double> scale;  // typical size of each coefficient (empty: 1), D = diag(scale)
  std::vector<double> lower;  // bounds, mm (empty: none)
  std::vector<double> upper;
  // The index of water is estimated too, from the one that the media say: only where cameras see the surface from
  // different sides or under different slopes. Its bounds; and the standard deviation from which on it counts as not
  // determined, whatever small scatter the corners show (never taken below kMinScatterPx).
  bool free_index = false;
  double index_lower = 1.30, index_upper = 1.40;
  double index_most_deviation = 0.005;
  // Returns true when time is up. Called once an iteration.
  bool (*deadline)(void*) = nullptr;
  void* deadline_context = nullptr;
};

// The least pivot (1 - R^2) of the index of water among the coefficients with which it is estimated.
inline constexpr double kIndexPivot = 1e-4;
inline constexpr double kMinScatterPx = 0.005;  // of a corner: none is found better, optics (20)

template <class S>
class SurfaceEstimator {
 public:
  // bottom_points: F, mm, W. options.scale/lower/upper: empty or one number a mode, else kInvalidArgument.
  // max_corners: over all cameras together, of which there are at most kMaxCameras.
  [[nodiscard]] static Result<SurfaceEstimator> make(const SurfaceModel<S>& model, const Media<S>& media,
                                                     std::span<const Vec3<S>> bottom_points, const EstimatorOptions& options,
                                                     int max_corners);

  // starts: one or more; the one with the lowest cost on these corners is refined (16). timed: the deadline holds.
  [[nodiscard]] Estimate<S> estimate(std::span<const CameraObservations<S>> cameras, std::span<const Coefficients<S>> starts,
                                     bool timed = true);
  // After an estimate that has not failed: |pixel error| / sigma of every corner, in the order in which they were given.
  void error_sizes(std::span<S> out) const;
  [[nodiscard]] const SurfaceModel<S>& model() const { return model_; }
  [[nodiscard]] Metric metric() const { return metric_; }
  // With free_index, with the index of the last surface.
  [[nodiscard]] const Media<S>& media() const { return media_; }
  [[nodiscard]] std::span<const Vec3<S>> bottom_points() const { return points_; }

 private:
  SurfaceEstimator() = default;
  [[nodiscard]] Stop prepare_corners(std::span<const CameraObservations<S>> cameras);
  [[nodiscard]] Stop choose_start(std::span<const Coefficients<S>> starts, CornerProblem<S>& problem, int& chosen);
  [[nodiscard]] int parameters() const { return model_.modes.size() + (optics_.free_index ? 1 : 0); }
  // Splits the index of water off.
  [[nodiscard]] Stop take_index(const Coefficients<double>& a, const InformationMatrix<double>& h, double s2,
                                Uncertainty& uncertainty, Estimate<S>& out) const;
  // Equal bounds: the coefficient is given, not estimated.
  [[nodiscard]] bool is_held(Eigen::Index mode) const {
    return solver_.lower.size() > 0 && solver_.upper.size() > 0 && solver_.lower[mode] == solver_.upper[mode];
  }
  [[nodiscard]] Stop finish(CornerProblem<S>& problem, const Coefficients<double>& a, const NormalEquations& sums,
                            Estimate<S>& out);

  SurfaceModel<S> model_;
  Media<S> media_;
  Metric metric_ = Metric::kReprojection;
  Loss loss_ = Loss::kNone;
  double index_most_deviation_ = 0;
  GaussNewtonOptions solver_;
  std::vector<Vec3<S>> points_;
  InformationMatrix<double> height_products_;  // mean of phi phi' over points_, one unit
  Optics<Lanes<S>> optics_;
  std::array<View<Lanes<S>>, kMaxCameras> views_;
  std::vector<PreparedCorner<Lanes<S>>> groups_;  // room for max_corners, each camera's last group filled up
  std::vector<double> sizes_;                     // of the residuals, one a corner
  std::size_t max_corners_ = 0, n_corners_ = 0, n_groups_ = 0;
  bool rays_ = false;  // groups_ hold the measured rays
};

extern template class SurfaceEstimator<float>;
extern template class SurfaceEstimator<double>;

}  // namespace srd::dsp
