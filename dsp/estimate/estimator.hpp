// Surface coefficients from corners of one to many cameras: damped Gauss-Newton with analytic derivatives.
// Optics (9)-(11), (13)-(17). Everything is sized at construction; estimate() does not allocate, throw or read a clock
// except through the deadline callback. One thread per object.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "dsp/optics/refraction.hpp"

namespace srd::dsp {

enum class Metric : std::uint8_t {
  kReprojection = 0,  // px, raw image (11)
  kDisparity = 1,     // mm on the bottom plane (9)
  kCollinearity = 2,  // rad, difference of normals (10)
};

// One corner whose identity is known.
template <class S>
struct Observation {
  int point = 0;         // index into the bottom points
  Vec2<S> pixel;         // raw image, px
  Vec2<S> normalised;    // the same corner undistorted: CameraModel::undistort(pixel)
  S sigma = 1;           // standard deviation per axis, px; weights are 1/sigma
};

// All corners of one camera in one frame.
template <class S>
struct CameraObservations {
  const View<S>* view = nullptr;
  std::span<const Observation<S>> corners;
};

// Why the iteration ended. Each is an inequality; numbers are on the wire.
enum class Stop : std::uint8_t {
  kGradient = 0,       // |D g|_inf <= epsg
  kCost = 1,           // relative fall of the cost <= epsf
  kStep = 2,           // |D^-1 delta|_2 <= epsx
  kMaxIterations = 3,  // maxits steps taken
  kDeadline = 4,       // the callback said stop; the best so far is returned
  kNoProgress = 5,     // damping at its limit and no step lowers the cost: as good as the arithmetic allows
  // Failures: no surface.
  kTooFewCorners = 16,  // fewer than ceil(parameters / 2) corners
  kSingular = 17,       // the corners do not determine the coefficients
  kNonFinite = 18,      // a NaN or infinity came in or up
  kOutOfDomain = 19,    // a ray misses the surface at every start
};
[[nodiscard]] constexpr bool failed(Stop stop) { return static_cast<std::uint8_t>(stop) >= 16; }

struct EstimatorOptions {
  Metric metric = Metric::kReprojection;
  double epsg = 0;         // 0: off; all three off and maxits 0: defaults 1e-9 of each kind
  double epsf = 0;
  double epsx = 0;
  int max_iterations = 0;  // 0: 50
  std::vector<double> scale;  // typical size of each coefficient (empty: 1), D = diag(scale)
  std::vector<double> lower;  // bounds, mm (empty: none)
  std::vector<double> upper;
  // Returns true when time is up. Called once an iteration.
  bool (*deadline)(void*) = nullptr;
  void* deadline_context = nullptr;
};

template <class S>
using InformationMatrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxModes, kMaxModes>;

template <class S>
struct Estimate {
  Stop stop = Stop::kTooFewCorners;
  Coefficients<S> coefficients;        // mm
  InformationMatrix<S> information;    // 1/mm^2; inverse of the covariance (17)
  Coefficients<S> standard_deviation;  // mm
  S mean_error = 0;                    // mean |e| over corners, in the metric's unit
  S reprojection_rms = 0;              // px per axis, whatever the metric
  S cost = 0;                          // sum of squared weighted residuals
  S variance_factor = 0;               // s2 = cost / (residuals - parameters); 1 when sigmas are right; 0 when undetermined
  int iterations = 0;
  int corners_used = 0;
  int start_used = 0;                  // which of the starts was best
  bool at_bound = false;
};

template <class S>
class SurfaceEstimator {
 public:
  // bottom_points: F, mm, W. options.scale/lower/upper: empty or one number a mode, else kInvalidArgument.
  // max_corners: over all cameras together.
  [[nodiscard]] static Result<SurfaceEstimator> make(const SurfaceModel<S>& model, const Media<S>& media,
                                                     std::span<const Vec3<S>> bottom_points,
                                                     const EstimatorOptions& options, int max_corners);

  // starts: one or more; the one with the lowest cost on these corners is refined (16).
  [[nodiscard]] Estimate<S> estimate(std::span<const CameraObservations<S>> cameras,
                                     std::span<const Coefficients<S>> starts);
  [[nodiscard]] const SurfaceModel<S>& model() const { return model_; }
  [[nodiscard]] const Media<S>& media() const { return media_; }
  [[nodiscard]] std::span<const Vec3<S>> bottom_points() const { return points_; }

 private:
  SurfaceModel<S> model_;
  Media<S> media_;
  std::vector<Vec3<S>> points_;
};

}  // namespace srd::dsp
