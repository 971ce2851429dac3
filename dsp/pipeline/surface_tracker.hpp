// SPDX-License-Identifier: Apache-2.0
// From images to a surface: finds the pattern, follows its corners by predicting them through the last surface, fits the
// next one. One to kMaxCameras cameras that look at one pattern. Optics (11), (15)-(17).
// Everything is sized at construction: process() does not allocate, throw, or read a clock. One thread per object.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/estimate/estimator/start_history.hpp"
#include "dsp/frontend/corner_tracker.hpp"
#include "dsp/pipeline/acquisition.hpp"
#include "dsp/pipeline/pattern.hpp"
#include "dsp/pipeline/predictor.hpp"
#include "dsp/pipeline/track_status.hpp"

namespace srd::dsp {

struct SurfaceTrackerOptions {
  DetectorOptions detector;       // for full detection; its region holds for tracking too
  int search_radius = 6;          // px round a prediction; never more than 0.4 of a square
  int min_corners = 0;            // over all cameras; 0: what the model needs, and two more
  double max_rms_px = 1.0;        // a fit worse than this is a wrong identity or a wrong model
  double max_deviation_mm = 1.0;  // a surface less sure than this (Estimate::height_deviation) is none; 0: no limit
  double outlier_factor = 5;      // corners beyond this times the frame's own scatter (median) are left out; 0: none
  double sigma_floor_px = 0.01;   // added to a corner's own deviation: what the surface model leaves over
  // A frame whose squared residuals, in units of what corners say of themselves, are so many times those of the frames before
  // is inconsistent; 0: none is. What a print's own faults leave is in the frames before, too.
  double inconsistent_factor = 9;
  bool weigh_corners = true;  // false: every corner counts alike, as in the published method
  // Monotonic time, ns, read twice a fit: for FrameResult's times. May not throw or block; null: they stay 0.
  std::int64_t (*now_ns)() = nullptr;
};

enum class TrackState : std::uint8_t { kSearching, kTracking, kLost };

template <class S>
struct FrameResult {
  TrackStatus status = TrackStatus::kNoPattern;
  TrackState state = TrackState::kSearching;  // after this frame
  bool acquired = false;                      // found by full detection in this frame
  int expected = 0;                           // corners predicted inside the images and regions
  int found = 0;                              // corners located
  Estimate<S> estimate;                       // valid with has_estimate(); estimate.corners_used were used
  // Time spent: prediction, detection and tracking of corners; fits of surfaces. 0 without
  // SurfaceTrackerOptions::now_ns.
  std::int64_t detection_ns = 0, estimation_ns = 0;
  bool has_surface() const { return status == TrackStatus::kOk; }
  // Also one that the frame contradicts: for whoever looks at the status.
  bool has_estimate() const {
    return has_surface() || status == TrackStatus::kInconsistent || status == TrackStatus::kInterlaced;
  }
  // The corners used, camera by camera; valid until the next process().
  std::array<std::span<const Observation<S>>, kMaxCameras> observations{};
};

template <class S>
struct CameraSetup {
  View<S> view;
  int width = 0, height = 0;  // px
  Region region{};            // where the pattern may be seen; empty: the whole image
};

template <class S>
class SurfaceTracker {
 public:
  // guess: one number a mode (mm), where the search starts. estimator: scale, bounds, stops, metric.
  // kInvalidArgument: no camera or more than kMaxCameras, sizes or lengths that do not fit.
  [[nodiscard]] static Result<SurfaceTracker> make(std::span<const CameraSetup<S>> cameras, const Pattern& pattern,
                                                   const SurfaceModel<S>& model, const Media<S>& media,
                                                   const Coefficients<S>& guess, const EstimatorOptions& estimator,
                                                   const SurfaceTrackerOptions& options);

  // One image a camera, exposed together at time_ns (only differences count).
  [[nodiscard]] const FrameResult<S>& process(std::span<const GrayView> images, std::int64_t time_ns);
  // Forgets the surface: the next frame is searched from the guess.
  void reset();

  [[nodiscard]] const Pattern& pattern() const { return pattern_; }
  [[nodiscard]] const SurfaceModel<S>& model() const { return estimator_.model(); }
  [[nodiscard]] const Media<S>& media() const { return estimator_.media(); }
  [[nodiscard]] Metric metric() const { return estimator_.metric(); }

 private:
  struct PerCamera {
    CameraSetup<S> setup;
    Predictor<S> predictions;            // one a point
    std::vector<std::int32_t> blur_q12;  // of each point, as last seen
    TrackOptions track;                  // its sharpening: as the last full detection found it
    std::vector<Observation<S>> observations;
    Acquisition<S> acquisition;
  };

  SurfaceTracker(SurfaceEstimator<S> estimator, const Pattern& pattern, const Coefficients<S>& guess);

  // Whether there is an image of the right size for every camera; begins a new result.
  [[nodiscard]] bool begin(std::span<const GrayView> images);
  // The surface through the corners that are found round their predictions.
  [[nodiscard]] TrackStatus track(std::span<const GrayView> images, std::span<const Coefficients<S>> starts,
                                  const Coefficients<S>& expected);
  // The surface through corners found anywhere, near the last surface first, then near the guess.
  [[nodiscard]] TrackStatus search(std::span<const GrayView> images, const Coefficients<S>& last);
  // Whether the frame contradicts itself although it has a surface.
  [[nodiscard]] TrackStatus examine(std::span<const GrayView> images);
  void remember(TrackStatus status, std::int64_t time_ns);
  void follow(PerCamera& camera, const GrayView& image);
  [[nodiscard]] TrackStatus acquire(PerCamera& camera, const GrayView& image);
  [[nodiscard]] int count_expected(const PerCamera& camera) const;
  // foot: of the point's prediction.
  void observe(PerCamera& camera, int point, const CornerFit& fit, const Vec2<S>& foot) const;
  [[nodiscard]] bool bright(int point) const { return pattern_.odd(point) != bright_origin_; }
  // timed: the estimator's deadline holds. A search of the whole image has none: it takes longer than any frame may.
  [[nodiscard]] TrackStatus estimate(std::span<const Coefficients<S>> starts, bool timed);
  [[nodiscard]] TrackStatus fit(std::span<const Coefficients<S>> starts, bool timed);
  [[nodiscard]] std::int64_t now_ns() const { return options_.now_ns != nullptr ? options_.now_ns() : 0; }
  [[nodiscard]] bool drop_outliers();
  [[nodiscard]] bool is_inconsistent();
  [[nodiscard]] bool is_interlaced(const PerCamera& camera, const GrayView& image) const;
  [[nodiscard]] int count_found() const;

  Pattern pattern_;
  std::vector<Vec3<S>> points_;
  SurfaceEstimator<S> estimator_;
  StartHistory<S> history_;
  Coefficients<S> guess_;
  SurfaceTrackerOptions options_;
  std::vector<PerCamera> cameras_;
  std::vector<S> errors_, sorted_errors_;
  bool bright_origin_ = false;  // the square towards +X +Y of W's origin is bright
  bool polarity_known_ = false;
  TrackState state_ = TrackState::kSearching;
  int missed_ = 0;               // frames without a surface in a row
  S usual_variance_ = 0;         // Estimate::variance_factor of the frames before; 0: none yet
  std::uint32_t processed_ = 0;  // frames
  FrameResult<S> result_;
};

extern template class SurfaceTracker<float>;
extern template class SurfaceTracker<double>;

}  // namespace srd::dsp
