// SPDX-License-Identifier: Apache-2.0
// A corner as the residuals take it: everything relative to its bottom point, so that float keeps micrometres at a
// metre's distance. Prepared once a frame, in double. T is a scalar, or Lanes of it for several corners at once.
#pragma once

#include <cmath>

#include "dsp/core/lanes.hpp"
#include "dsp/estimate/residual/observation.hpp"
#include "dsp/estimate/residual/sight_line.hpp"

namespace srd::dsp {

template <class T>
struct PreparedCorner : SightLine<T> {
  Vec2<T> pixel;        // q, raw px
  T weight;             // 1/sigma, 1/px; 0: a lane without a corner
  Vec2<T> normalised;   // q undistorted; from here on to dry_distance with prepare_ray() only
  Vec3<T> direction;    // d of the measured ray, unit
  Vec2<T> dry;          // where the measured ray meets Z = F_z, from F, mm
  T dry_distance;       // from c along d to there, mm
  Vec2<T> first_foot;   // see Observation::foot
  T trusted = 1;        // 0: gross, see CornerProblem::distrust_gross
  T along;              // of the measured ray's surface point, from the dry point along d, mm; <= 0; as foot
  Vec2<T> pixel_error;  // of the last evaluation with derivatives, px
};

// A camera as prepare() takes it.
struct WideView {
  Mat3<double> rotation;
  Vec3<double> centre;
  CameraModel<double> camera;

  template <class S>
  explicit WideView(const View<S>& view)
      : rotation(view.pose.rotation.template cast<double>()),
        centre(-(rotation.transpose() * view.pose.translation.template cast<double>())),
        camera(view.camera.template cast<double>()) {}
};

// What a corner is however it is measured. out.view is left alone. False: F lies behind the camera.
template <class S>
[[nodiscard]] bool prepare(const Observation<S>& seen, const Vec3<S>& point, const WideView& view, PreparedCorner<S>& out) {
  const Vec3<double> camera_from_point = view.centre - point.template cast<double>();
  const Vec3<double> in_camera = -(view.rotation * camera_from_point);
  if (!(in_camera.z() > 0)) return false;
  out.point = point;
  out.pixel = seen.pixel;
  out.weight = 1 / seen.sigma;
  out.camera_from_point = camera_from_point.cast<S>();
  out.point_in_camera = in_camera.cast<S>();
  out.first_foot = seen.foot;
  return true;
}

// The measured ray, of a corner that is prepared. refine: the undistorted corner gets one more Newton step in double.
// False: the ray runs level or upward.
template <class S>
[[nodiscard]] bool prepare_ray(const Observation<S>& seen, const WideView& view, bool refine, PreparedCorner<S>& out) {
  Vec2<double> xy = seen.normalised.template cast<double>();
  if (refine) {
    Mat2<double> pixel_xy, xy_pixel;
    const Vec2<double> e = view.camera.pixel(xy, &pixel_xy) - seen.pixel.template cast<double>();
    if (!invert(pixel_xy, xy_pixel)) return false;
    xy -= xy_pixel * e;
  }
  const Vec3<double> d = (view.rotation.transpose() * Vec3<double>(xy.x(), xy.y(), 1)).normalized();
  if (!(d.z() < 0)) return false;
  const Vec3<double> camera_from_point = view.centre - out.point.template cast<double>();
  const double distance = -camera_from_point.z() / d.z();
  if (!(distance > 0)) return false;
  out.normalised = xy.cast<S>();
  out.direction = d.cast<S>();
  out.dry = (camera_from_point + distance * d).template head<2>().cast<S>();
  out.dry_distance = static_cast<S>(distance);
  return true;
}

// Puts one corner into a lane; of what an evaluation starts from, nothing.
template <class S>
void put(const PreparedCorner<S>& corner, bool ray, int lane, PreparedCorner<Lanes<S>>& out) {
  const auto each = [lane](const auto& from, auto& to) {
    for (Eigen::Index i = 0; i < from.size(); ++i) to[i].set(lane, from[i]);
  };
  each(corner.point, out.point);
  each(corner.pixel, out.pixel);
  out.weight.set(lane, corner.weight);
  each(corner.camera_from_point, out.camera_from_point);
  each(corner.point_in_camera, out.point_in_camera);
  each(corner.first_foot, out.first_foot);
  if (!ray) return;
  each(corner.normalised, out.normalised);
  each(corner.direction, out.direction);
  each(corner.dry, out.dry);
  out.dry_distance.set(lane, corner.dry_distance);
}

// Starts the corner's Newton iterations where the measured ray meets the plane Z = level, mm, or at the known foot; one of
// the two must be there.
template <class T>
void start_at_level(T level, bool ray, PreparedCorner<T>& corner) {
  using std::isfinite;
  const bool known = isfinite(corner.first_foot.x() + corner.first_foot.y());
  if (known) corner.foot = corner.first_foot;
  if (!ray) return;
  corner.along = (level - corner.point.z()) / corner.direction.z();
  if (!known) corner.foot = corner.dry + corner.along * corner.direction.template head<2>();
}

}  // namespace srd::dsp
