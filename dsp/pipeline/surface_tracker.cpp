// SPDX-License-Identifier: Apache-2.0
#include "dsp/pipeline/surface_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace srd::dsp {

namespace {
constexpr std::int32_t kUsualBlurQ12 = CornerShape{}.blur_q12;  // until a corner tells better
constexpr int kPatience = 25;  // frames without a surface after which the last one says nothing any more
}  // namespace

template <class S>
SurfaceTracker<S>::SurfaceTracker(SurfaceEstimator<S> estimator, const Pattern& pattern, const Coefficients<S>& guess)
    : pattern_(pattern), estimator_(std::move(estimator)), history_(guess), guess_(guess) {}

template <class S>
Result<SurfaceTracker<S>> SurfaceTracker<S>::make(std::span<const CameraSetup<S>> cameras, const Pattern& pattern,
                                                  const SurfaceModel<S>& model, const Media<S>& media,
                                                  const Coefficients<S>& guess, const EstimatorOptions& estimator,
                                                  const SurfaceTrackerOptions& options) {
  if (cameras.empty() || cameras.size() > kMaxCameras || guess.size() != model.modes.size()) return Errc::kInvalidArgument;
  std::vector<Vec3<S>> points;
  for (const Vec3<double>& p : pattern.points()) points.push_back(p.cast<S>());
  Result<SurfaceEstimator<S>> made =
      SurfaceEstimator<S>::make(model, media, points, estimator, pattern.size() * static_cast<int>(cameras.size()));
  if (!made) return made.error();
  SurfaceTracker tracker(std::move(made).value(), pattern, guess);
  tracker.points_ = std::move(points);
  tracker.options_ = options;
  const TrackOptions track{options.detector.response, options.detector.threshold, options.detector.fit};
  if (tracker.options_.min_corners <= 0) tracker.options_.min_corners = (model.modes.size() + 1) / 2 + 2;
  tracker.polarity_known_ = pattern.first_square() != FirstSquare::kUnknown;
  tracker.bright_origin_ = pattern.first_square() == FirstSquare::kBright;
  const std::size_t n = static_cast<std::size_t>(pattern.size());
  for (const CameraSetup<S>& setup : cameras) {
    if (setup.width <= 0 || setup.height <= 0) return Errc::kInvalidArgument;
    PerCamera& camera = tracker.cameras_.emplace_back(PerCamera{setup,
                                                                Predictor<S>(setup.view, model, media, tracker.points_),
                                                                {},
                                                                track,
                                                                {},
                                                                Acquisition<S>(setup.width, setup.height, pattern.size())});
    camera.blur_q12.assign(n, kUsualBlurQ12);
    camera.observations.reserve(n);
  }
  tracker.errors_.reserve(n * cameras.size());
  tracker.sorted_errors_.reserve(n * cameras.size());
  return tracker;
}

template <class S>
void SurfaceTracker<S>::reset() {
  history_.reset();
  state_ = TrackState::kSearching;
}

template <class S>
const FrameResult<S>& SurfaceTracker<S>::process(std::span<const GrayView> images, std::int64_t time_ns) {
  // Step 1: the images, as the cameras were set up.
  if (!begin(images)) return result_;
  const std::int64_t started = now_ns();

  // Step 2: corners round where the last surfaces predict them, and the surface through them.
  const std::span<const Coefficients<S>> starts = history_.starts(time_ns);
  TrackStatus status = TrackStatus::kNoPattern;
  if (state_ == TrackState::kTracking) status = track(images, starts, history_.expected(time_ns));

  // Step 3: lost, or never had: corners anywhere in the images.
  if (status != TrackStatus::kOk) status = search(images, starts.front());

  // Step 4: what the next frame starts from. The track goes on whatever step 5 says: what a frame contradicts is its
  // surface, not where the corners are.
  remember(status, time_ns);

  // Step 5: does the frame agree with itself and with those before?
  if (status == TrackStatus::kOk) status = examine(images);

  ++processed_;
  result_.detection_ns = now_ns() - started - result_.estimation_ns;
  result_.status = status;
  result_.state = state_;
  result_.found = count_found();
  for (std::size_t c = 0; c < cameras_.size(); ++c) result_.observations[c] = cameras_[c].observations;
  return result_;
}

template <class S>
bool SurfaceTracker<S>::begin(std::span<const GrayView> images) {
  result_.status = TrackStatus::kBadImage;
  result_.state = state_;
  result_.acquired = false;
  result_.expected = result_.found = 0;
  result_.estimate = Estimate<S>{};
  result_.detection_ns = result_.estimation_ns = 0;
  result_.observations = {};
  if (images.size() != cameras_.size()) return false;
  for (std::size_t c = 0; c < cameras_.size(); ++c)
    if (images[c].width != cameras_[c].setup.width || images[c].height != cameras_[c].setup.height) return false;
  return true;
}

template <class S>
TrackStatus SurfaceTracker<S>::track(std::span<const GrayView> images, std::span<const Coefficients<S>> starts,
                                     const Coefficients<S>& expected) {
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    cameras_[c].predictions.predict(expected);
    follow(cameras_[c], images[c]);
  }
  return estimate(starts, true);
}

template <class S>
TrackStatus SurfaceTracker<S>::search(std::span<const GrayView> images, const Coefficients<S>& last) {
  TrackStatus status = TrackStatus::kNoPattern;
  for (const Coefficients<S>* from : {&last, &std::as_const(guess_)}) {
    if (from == &guess_ && history_.size() == 0) break;  // the guess has had its turn
    TrackStatus found = TrackStatus::kOk;
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      cameras_[c].predictions.predict(*from);
      const TrackStatus here = acquire(cameras_[c], images[c]);
      if (here != TrackStatus::kOk) found = here;
    }
    const TrackStatus fitted = estimate(std::span<const Coefficients<S>>(from, 1), false);
    // With several cameras, one may see the pattern while another does not.
    status = fitted == TrackStatus::kTooFewCorners && found != TrackStatus::kOk ? found : fitted;
    result_.acquired = status == TrackStatus::kOk;
    if (result_.acquired) break;
  }
  return status;
}

template <class S>
void SurfaceTracker<S>::remember(TrackStatus status, std::int64_t time_ns) {
  if (status == TrackStatus::kOk) {
    history_.add(time_ns, result_.estimate.coefficients);
    missed_ = 0;
    state_ = TrackState::kTracking;
    return;
  }
  if (state_ == TrackState::kTracking) state_ = TrackState::kLost;
  if (++missed_ > kPatience) history_.reset();
  if (history_.size() == 0) state_ = TrackState::kSearching;
}

template <class S>
TrackStatus SurfaceTracker<S>::examine(std::span<const GrayView> images) {
  bool interlaced = false;
  for (std::size_t c = 0; c < cameras_.size(); ++c) interlaced = is_interlaced(cameras_[c], images[c]) || interlaced;
  const bool inconsistent = is_inconsistent();  // follows the frames, so every one is shown to it
  if (interlaced) return TrackStatus::kInterlaced;
  return inconsistent ? TrackStatus::kInconsistent : TrackStatus::kOk;
}

// Looks for each point round its prediction.
template <class S>
void SurfaceTracker<S>::follow(PerCamera& camera, const GrayView& image) {
  camera.observations.clear();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!camera.predictions.valid(i)) continue;
    const Prediction<S>& p = camera.predictions[i];
    // The next corner of the pattern must stay outside, or identity is a guess.
    const S step = static_cast<S>(pattern_.square()) * std::min(p.pixel_per_mm.col(0).norm(), p.pixel_per_mm.col(1).norm());
    const int radius = std::min(options_.search_radius, static_cast<int>(S(0.4) * step));
    if (radius < 1) continue;
    if (i + 1 < points_.size() && camera.predictions.valid(i + 1)) {
      const Vec2<S>& next = camera.predictions[i + 1].pixel;
      prefetch_window(image, static_cast<int>(next.x()), static_cast<int>(next.y()), radius + camera.track.response.radius);
    }
    CornerFit fit;
    const Tracked tracked =
        track_corner(image, camera.setup.region, expected_shape(p, bright(static_cast<int>(i)), camera.blur_q12[i]), radius,
                     camera.track, fit);
    if (tracked == Tracked::kOutside) continue;
    ++result_.expected;
    if (tracked != Tracked::kFound) continue;
    camera.blur_q12[i] = fit.shape.blur_q12;
    observe(camera, static_cast<int>(i), fit, p.foot);
  }
  camera.predictions.undistort(camera.observations);
}

// Looks for the pattern anywhere.
template <class S>
TrackStatus SurfaceTracker<S>::acquire(PerCamera& camera, const GrayView& image) {
  camera.observations.clear();
  result_.expected += count_expected(camera);
  DetectorOptions detector = options_.detector;
  detector.region = camera.setup.region;
  const std::optional<bool> known = polarity_known_ ? std::optional(bright_origin_) : std::nullopt;
  const TrackStatus status =
      camera.acquisition.find(image, detector, pattern_, camera.predictions, known, options_.min_corners);
  camera.track.fit.sharpening = camera.acquisition.sharpening();
  if (status != TrackStatus::kOk) return status;
  bright_origin_ = camera.acquisition.bright_origin();
  for (const PlacedCorner& corner : camera.acquisition.corners()) {
    camera.blur_q12[static_cast<std::size_t>(corner.point)] = corner.fit.shape.blur_q12;
    observe(camera, corner.point, corner.fit, Observation<S>().foot);
  }
  camera.predictions.undistort(camera.observations);
  return status;
}

// Predicted inside the image and its region.
template <class S>
int SurfaceTracker<S>::count_expected(const PerCamera& camera) const {
  const Region whole{0, 0, camera.setup.width, camera.setup.height};
  const Region& r = camera.setup.region.empty() ? whole : camera.setup.region;
  const auto within = [](S x, int low, int high) { return x >= static_cast<S>(low) && x < static_cast<S>(high); };
  int n = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!camera.predictions.valid(i)) continue;
    const Vec2<S>& q = camera.predictions[i].pixel;
    n += within(q.x(), r.u0, r.u1) && within(q.y(), r.v0, r.v1) ? 1 : 0;
  }
  return n;
}

template <class S>
void SurfaceTracker<S>::observe(PerCamera& camera, int point, const CornerFit& fit, const Vec2<S>& foot) const {
  Observation<S> o;
  o.point = point;
  o.foot = foot;
  o.normalised.setZero();  // until Predictor::undistort
  o.pixel = {fit.corner.u.template to<S>(), fit.corner.v.template to<S>()};
  if (options_.weigh_corners) {
    const S own = static_cast<S>(fit.corner.sigma_q12) / S(4096), floor = static_cast<S>(options_.sigma_floor_px);
    o.sigma = std::sqrt(own * own + floor * floor);
  }
  camera.observations.push_back(o);
}

template <class S>
int SurfaceTracker<S>::count_found() const {
  int n = 0;
  for (const PerCamera& camera : cameras_) n += static_cast<int>(camera.observations.size());
  return n;
}

template <class S>
TrackStatus SurfaceTracker<S>::estimate(std::span<const Coefficients<S>> starts, bool timed) {
  const std::int64_t begin = now_ns();
  const TrackStatus status = fit(starts, timed);
  result_.estimation_ns += now_ns() - begin;
  return status;
}

template <class S>
TrackStatus SurfaceTracker<S>::fit(std::span<const Coefficients<S>> starts, bool timed) {
  std::array<CameraObservations<S>, kMaxCameras> seen;
  const auto fit_once = [&]() {
    for (std::size_t c = 0; c < cameras_.size(); ++c) seen[c] = {&cameras_[c].setup.view, cameras_[c].observations};
    result_.estimate = estimator_.estimate(std::span(seen).first(cameras_.size()), starts, timed);
    if (failed(result_.estimate.stop)) return TrackStatus::kSolverFailed;
    if (options_.max_deviation_mm > 0 && !(result_.estimate.height_deviation <= static_cast<S>(options_.max_deviation_mm)))
      return TrackStatus::kTooFewCorners;
    // The best so far of corners that a prediction identified; estimate.stop says that it is no more.
    if (result_.estimate.stop == Stop::kDeadline) return TrackStatus::kOk;
    return result_.estimate.reprojection_rms <= static_cast<S>(options_.max_rms_px) ? TrackStatus::kOk : TrackStatus::kPoorFit;
  };
  if (count_found() < options_.min_corners) return TrackStatus::kTooFewCorners;
  TrackStatus status = fit_once();
  if (status == TrackStatus::kSolverFailed || result_.estimate.stop == Stop::kDeadline) return status;
  if (options_.outlier_factor > 0 && drop_outliers()) {
    if (count_found() < options_.min_corners) return TrackStatus::kTooFewCorners;
    const Coefficients<S> refined = result_.estimate.coefficients;
    starts = std::span<const Coefficients<S>>(&refined, 1);
    status = fit_once();
  }
  return status;
}

// Leaves out corners whose reprojection is far beyond the frame's own scatter: hidden edges, floating dirt, reflections.
template <class S>
bool SurfaceTracker<S>::drop_outliers() {
  errors_.resize(static_cast<std::size_t>(count_found()));
  estimator_.error_sizes(errors_);
  const std::size_t n = errors_.size();
  if (n < 8) return false;  // too few to say what is usual
  std::vector<S>& sorted = sorted_errors_;
  sorted.assign(errors_.begin(), errors_.end());
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2), sorted.end());
  // The median of |e| of two normal components is 1.18 standard deviations.
  const S limit = static_cast<S>(options_.outlier_factor) * std::max(sorted[n / 2] / S(1.18), S(1));
  bool dropped = false;
  std::size_t at = 0;
  for (PerCamera& camera : cameras_) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < camera.observations.size(); ++i, ++at)
      if (errors_[at] <= limit) camera.observations[kept++] = camera.observations[i];
    dropped = dropped || kept != camera.observations.size();
    camera.observations.resize(kept);
  }
  return dropped;
}

// Follows what residuals usually are, faster down than up, so that a row of bad frames does not become the rule at once.
template <class S>
bool SurfaceTracker<S>::is_inconsistent() {
  constexpr int kFewCorners = 10;  // whose residuals say little
  const S now = result_.estimate.variance_factor;
  const Stop stop = result_.estimate.stop;
  if (stop == Stop::kDeadline || stop == Stop::kMaxIterations) return false;  // not its corners' fault
  if (options_.inconsistent_factor <= 0 || result_.estimate.corners_used < kFewCorners || !(now > 0)) return false;
  if (usual_variance_ <= 0) usual_variance_ = now;
  const bool inconsistent = now > static_cast<S>(options_.inconsistent_factor) * std::max(usual_variance_, S(1));
  usual_variance_ += (now < usual_variance_ ? S(0.2) : S(0.02)) * (now - usual_variance_);
  return inconsistent;
}

// A few corners of a frame, others in the next: their even rows against their odd ones.
template <class S>
bool SurfaceTracker<S>::is_interlaced(const PerCamera& camera, const GrayView& image) const {
  constexpr std::size_t kLooked = 4;
  // Chi-square of 2 and, for all, 8 degrees of freedom: 1 in 10^6 and 1 in 10^11 of progressive frames.
  constexpr float kSurely = 28, kAllSurely = 68;
  const std::size_t n = camera.observations.size();
  if (n < kLooked) return false;
  CornerFitOptions options = camera.track.fit;
  options.compare_rows = true;
  int apart = 0;
  float sum = 0;
  for (std::size_t k = 0; k < kLooked; ++k) {
    const Observation<S>& o = camera.observations[(processed_ + k * n / kLooked) % n];
    const auto point = static_cast<std::size_t>(o.point);
    CornerShape start = expected_shape(camera.predictions[point], bright(o.point), camera.blur_q12[point]);
    start.u = Pixel::from_raw(static_cast<std::int32_t>(std::lround(o.pixel.x() * S(Pixel::kOne))));
    start.v = Pixel::from_raw(static_cast<std::int32_t>(std::lround(o.pixel.y() * S(Pixel::kOne))));
    CornerFit fit;
    if (!fit_corner(image, start, options, fit)) continue;
    sum += fit.rows_apart;
    apart += fit.rows_apart > kSurely ? 1 : 0;
  }
  return apart >= 2 && sum > kAllSurely;
}

template class SurfaceTracker<float>;
template class SurfaceTracker<double>;

}  // namespace srd::dsp
