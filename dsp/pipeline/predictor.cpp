// SPDX-License-Identifier: Apache-2.0
#include "dsp/pipeline/predictor.hpp"

#include <algorithm>

namespace srd::dsp {

namespace {
// Of a foot, mm: some hundredths of a pixel, where corners are looked for within several.
constexpr double kPredictedWithin = 1e-2;
}  // namespace

template <class S>
Predictor<S>::Predictor(const View<S>& view, const SurfaceModel<S>& model, const Media<S>& media,
                        std::span<const Vec3<S>> points)
    : view_(view),
      media_(media),
      model_(model),
      wide_view_(view.template cast<T>()),
      optics_(Optics<T>::make(model, media, kPredictedWithin)),
      points_(points.begin(), points.end()),
      predictions_(points.size()),
      valid_(points.size(), 0),
      groups_((points.size() + T::kSize - 1) / T::kSize) {
  const Vec3<S> centre = view.pose.centre();
  for (std::size_t i = 0; i < groups_.size() * T::kSize; ++i) {
    const Vec3<S>& f = points_[i < points_.size() ? i : points_.size() - 1];
    SightLine<T>& line = groups_[i / T::kSize].line;
    const int lane = static_cast<int>(i % T::kSize);
    const Vec3<S> to_camera = centre - f, in_camera = view.pose.rotation * f + view.pose.translation;
    for (int k = 0; k < 3; ++k) {
      line.point[k].set(lane, f[k]);
      line.camera_from_point[k].set(lane, to_camera[k]);
      line.point_in_camera[k].set(lane, in_camera[k]);
    }
  }
}

template <class S>
void Predictor<S>::predict(const Coefficients<S>& a) {
  Coefficients<T> wide(a.size());
  for (Eigen::Index i = 0; i < a.size(); ++i) wide[i] = T(a[i]);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Group& group = groups_[g];
    group.line.view = &wide_view_;
    if (!group.started) start(a, group.line);
    Sighting<T> seen;
    group.started = sight(optics_, wide, group.line, static_cast<Basis<T>*>(nullptr), true, seen);
    const std::size_t first = g * T::kSize, last = std::min(first + T::kSize, points_.size());
    for (std::size_t i = first; i < last; ++i)
      valid_[i] = group.started ? take(seen, group.line, static_cast<int>(i - first), predictions_[i]) : alone(a, i);
  }
}

template <class S>
void Predictor<S>::start(const Coefficients<S>& a, SightLine<T>& line) const {
  const int constant = model_.modes.index_of(Mode{});
  const T level(constant >= 0 ? a[constant] : model_.height(a, points_[0].x(), points_[0].y()));
  const T part = (level - line.point.z()) / line.camera_from_point.z();
  line.foot = Vec2<T>(part * line.camera_from_point.x(), part * line.camera_from_point.y());
}

template <class S>
char Predictor<S>::take(const Sighting<T>& seen, const SightLine<T>& line, int lane, Prediction<S>& out) {
  for (int r = 0; r < 2; ++r) {
    out.normalised[r] = seen.seen[r][lane];
    out.pixel[r] = seen.pixel[r][lane];
    out.foot[r] = line.foot[r][lane];
    for (int c = 0; c < 2; ++c) out.pixel_per_mm(r, c) = seen.pixel_point(r, c)[lane];
  }
  return out.pixel.cwiseAbs().maxCoeff() < S(100000) && out.pixel_per_mm.allFinite() ? 1 : 0;
}

template <class S>
char Predictor<S>::alone(const Coefficients<S>& a, std::size_t i) {
  const Result<Vec2<S>> direct = view_.normalised(points_[i]);
  if (!direct) return 0;
  const Result<Prediction<S>> p = dsp::predict(view_, model_, a, media_, points_[i], *direct);
  if (!p) return 0;
  predictions_[i] = *p;
  return 1;
}

template <class S>
void Predictor<S>::undistort(std::vector<Observation<S>>& corners) const {
  std::size_t kept = 0;
  for (std::size_t first = 0; first < corners.size(); first += T::kSize) {
    const std::size_t n = std::min<std::size_t>(T::kSize, corners.size() - first);
    const bool all = undistort_together(std::span(corners).subspan(first, n));
    for (std::size_t i = first; i < first + n; ++i) {
      if (!all) {
        const Result<Vec2<S>> one = view_.camera.undistort(corners[i].pixel);
        if (!one) continue;
        corners[i].normalised = *one;
      }
      if (kept != i) corners[kept] = corners[i];
      ++kept;
    }
  }
  corners.resize(kept);
}

template <class S>
bool Predictor<S>::undistort_together(std::span<Observation<S>> few) const {
  Vec2<T> pixel, xy;
  for (int lane = 0; lane < T::kSize; ++lane) {
    const Observation<S>& corner = few[std::min(static_cast<std::size_t>(lane), few.size() - 1)];
    const Prediction<S>& start = predictions_[static_cast<std::size_t>(corner.point)];
    for (int k = 0; k < 2; ++k) {
      pixel[k].set(lane, corner.pixel[k]);
      xy[k].set(lane, start.normalised[k]);
    }
  }
  Vec2<T> step;
  for (int turn = 0; turn < 2; ++turn) {
    Mat2<T> pixel_xy, xy_pixel;
    const Vec2<T> e = wide_view_.camera.pixel(xy, &pixel_xy) - pixel;
    if (!invert(pixel_xy, xy_pixel)) return false;
    step = xy_pixel * e;
    xy -= step;
  }
  // Newton's error after a step x is about x^2 times the curvature of the map, which is below 10 where it can be inverted.
  const T within = static_cast<S>(sizeof(S) > sizeof(float) ? 1e-5 : 1e-4);
  if (!(step.squaredNorm() <= within * within)) return false;
  for (std::size_t i = 0; i < few.size(); ++i)
    for (int k = 0; k < 2; ++k) few[i].normalised[k] = xy[k][static_cast<int>(i)];
  return true;
}

template class Predictor<float>;
template class Predictor<double>;

}  // namespace srd::dsp
