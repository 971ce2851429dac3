// A corner as the residuals take it: everything relative to its bottom point, so that float keeps micrometres at a
// metre's distance. Prepared once a frame, in double.
#pragma once

#include <algorithm>
#include <cmath>

#include "dsp/estimate/observation.hpp"
#include "dsp/optics/crossing.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd::dsp {

template <class S>
struct PreparedCorner {
  Vec3<S> point;              // F, mm, W
  Vec2<S> pixel;              // q, raw px
  Vec2<S> normalised;         // q undistorted
  S weight = 1;               // 1/sigma, 1/px
  const View<S>* view = nullptr;
  Vec3<S> camera_from_point;  // c - F, mm
  Vec3<S> point_in_camera;    // R F + T, mm
  Vec3<S> direction;          // d of the measured ray, unit
  Vec2<S> dry;                // where the measured ray meets Z = F_z, from F, mm
  S dry_distance = 0;         // from c along d to there, mm
  // Where the last evaluation ended; the next one starts there.
  Vec2<S> foot;               // of the ray that would see F, from F, mm
  S along = 0;                // of the measured ray's surface point, from the dry point along d, mm; <= 0
};

// What all corners of an evaluation share.
template <class S>
struct Optics {
  const SurfaceModel<S>* model = nullptr;
  const Media<S>* media = nullptr;
  // Newton's error after a step of x mm is about x^2 10 / min(Lx, Ly) (curvature of the map over one mode's length):
  // below this step the next one would be under 1e-10 mm (double) or 1e-5 mm (float) and is not made.
  S last_step = 0;

  static Optics make(const SurfaceModel<S>& model, const Media<S>& media) {
    const double error = sizeof(S) > sizeof(float) ? 1e-10 : 1e-5;
    const double length = static_cast<double>(std::min(model.lx, model.ly));
    return {&model, &media, static_cast<S>(std::sqrt(error * length / 10))};
  }
};

// refine: unless null, the camera with which the undistorted corner gets one more Newton step in double.
// False: the ray runs level or upward, or F lies behind the camera.
template <class S>
[[nodiscard]] bool prepare(const Observation<S>& seen, const Vec3<S>& point, const View<S>& view,
                           const Vec3<double>& centre, const Mat3<double>& rotation,
                           const CameraModel<double>* refine, PreparedCorner<S>& out) {
  const Vec3<double> f = point.template cast<double>();
  Vec2<double> xy = seen.normalised.template cast<double>();
  if (refine != nullptr) {
    Mat2<double> pixel_xy, xy_pixel;
    const Vec2<double> e = refine->pixel(xy, &pixel_xy) - seen.pixel.template cast<double>();
    if (!invert(pixel_xy, xy_pixel)) return false;
    xy -= xy_pixel * e;
  }
  const Vec3<double> d = (rotation.transpose() * Vec3<double>(xy.x(), xy.y(), 1)).normalized();
  if (!(d.z() < 0)) return false;
  const Vec3<double> camera_from_point = centre - f;
  const Vec3<double> in_camera = -(rotation * camera_from_point);
  if (!(in_camera.z() > 0)) return false;
  const double distance = -camera_from_point.z() / d.z();
  if (!(distance > 0)) return false;
  out.point = point;
  out.pixel = seen.pixel;
  out.normalised = xy.cast<S>();
  out.weight = 1 / seen.sigma;
  out.view = &view;
  out.camera_from_point = camera_from_point.cast<S>();
  out.point_in_camera = in_camera.cast<S>();
  out.direction = d.cast<S>();
  out.dry = (camera_from_point + distance * d).template head<2>().cast<S>();
  out.dry_distance = static_cast<S>(distance);
  return true;
}

// Starts the corner's Newton iterations where the measured ray meets the plane Z = level, mm.
template <class S>
void start_at_level(S level, PreparedCorner<S>& corner) {
  corner.along = (level - corner.point.z()) / corner.direction.z();
  corner.foot = corner.dry + corner.along * corner.direction.template head<2>();
}

}  // namespace srd::dsp
