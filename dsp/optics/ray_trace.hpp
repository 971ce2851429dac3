// SPDX-License-Identifier: Apache-2.0
// From a ray in air through the surface, the water and flat floor plates to the pattern, with derivatives; and back.
// Optics (6)-(8), (13), (14). The ray meets the surface once; multiple crossings of steep waves are not modelled.
#pragma once

#include <cmath>
#include <limits>

#include "dsp/optics/refraction.hpp"
#include "dsp/optics/surface_model.hpp"
#include "dsp/optics/view.hpp"

namespace srd::dsp {

// One ray's way and what its bottom point depends on.
template <class S>
struct Trace {
  Vec3<S> surface_point;    // p, mm
  Vec3<S> normal;           // n, unit, up
  Vec3<S> water_direction;  // v, unit
  Vec2<S> bottom;           // b in the plane Z = bottom_z, mm
  S distance = 0;           // t, mm along the ray in air
  // db/da_j = d_height phi_j + d_slope (phi_j,x , phi_j,y): all of (13) and (14) in six numbers a point.
  Vec2<S> d_height = Vec2<S>::Zero();
  Mat2<S> d_slope = Mat2<S>::Zero();
  // db/d(direction of the ray in air), for directions that stay unit length.
  Mat23<S> d_direction = Mat23<S>::Zero();
};

// Where the ray meets the surface: Newton (6) from the start distance t (<= 0: from the plane z = start height).
template <class S>
[[nodiscard]] Result<S> intersect(const Ray<S>& ray, const SurfaceModel<S>& model, const Coefficients<S>& a, S start_t,
                                  SurfaceSample<S>& at) {
  constexpr int kMaxIterations = 30;
  const Vec3<S>& d = ray.direction;
  if (!(d.z() < 0)) return Errc::kOutOfDomain;
  S t = start_t;
  if (!(t > 0)) {
    // The level of the constant mode, or the model's height below the camera where there is none.
    const int level = model.modes.index_of(Mode{});
    const S z = level >= 0 ? a[level] : model.height(a, ray.origin.x(), ray.origin.y());
    t = (z - ray.origin.z()) / d.z();
    if (!(t > 0)) t = 0;
  }
  const S tolerance = 16 * std::numeric_limits<S>::epsilon() * (std::abs(ray.origin.z()) + std::abs(t));
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Vec3<S> p = ray.origin + t * d;
    at = model.sample(a, p.x(), p.y());
    const S slope = d.z() - at.zx * d.x() - at.zy * d.y();
    if (!(slope < 0)) return Errc::kOutOfDomain;  // grazing or leaving: not a view from above
    const S step = (p.z() - at.z) / slope;
    t -= step;
    if (!std::isfinite(t)) return Errc::kOutOfDomain;
    if (std::abs(step) <= tolerance) {
      if (!(t > 0)) return Errc::kOutOfDomain;
      // The step is below rounding, but slopes enter the refraction: take the sample there.
      return t;
    }
  }
  return Errc::kNotConverged;
}

// Follows the ray to the plane Z = bottom_z. derivatives: fill the d_ members too.
// kOutOfDomain: the ray misses the surface from above, or is totally reflected, or the surface lies below the bottom.
template <class S>
[[nodiscard]] Result<void, Errc> trace(const Ray<S>& ray, const SurfaceModel<S>& model, const Coefficients<S>& a,
                                       const Media<S>& media, S bottom_z, bool derivatives, Trace<S>& out, S start_t = 0) {
  SurfaceSample<S> at;
  const Result<S> t = intersect(ray, model, a, start_t, at);
  if (!t) return t.error();
  const Vec3<S>& d = ray.direction;
  const Vec3<S> p = ray.origin + *t * d;
  Crossing<S> crossing;
  if (!cross(d, at.zx, at.zy, p.z() - bottom_z, media, derivatives, crossing)) return Errc::kOutOfDomain;
  out.surface_point = p;
  out.normal = crossing.normal;
  out.water_direction = crossing.water_direction;
  out.bottom = p.template head<2>() + crossing.offset;
  out.distance = *t;
  if (!derivatives) return {};

  Mat23<S> db_dp;
  db_dp << Mat2<S>::Identity(), crossing.by_height;
  out.d_slope = crossing.by_slope;
  // A raised surface moves p by d/h along the ray (13), and with it the slopes by their curvature (14).
  const S h = d.z() - at.zx * d.x() - at.zy * d.y();
  Mat2<S> curvature;
  curvature << at.zxx, at.zxy, at.zxy, at.zyy;
  out.d_height = (db_dp * d + out.d_slope * (curvature * d.template head<2>())) / h;
  // A turned ray: dp = t dd + d dt with m'dp = 0, dt = -t m'dd/h; slopes follow by the curvature.
  const Vec3<S> m(-at.zx, -at.zy, 1);
  const Mat3<S> dp_dd = *t * (Mat3<S>::Identity() - d * m.transpose() / h);
  out.d_direction = db_dp * dp_dd + crossing.by_direction + out.d_slope * (curvature * dp_dd.template topRows<2>());
  return {};
}

// Where the camera sees a bottom point through the surface: Newton on (8) in normalised coordinates from the start.
// Returns normalised undistorted coordinates; trace_out holds the final ray with derivatives, b_xy = db/d(x, y).
template <class S>
[[nodiscard]] Result<Vec2<S>> see_through(const View<S>& view, const SurfaceModel<S>& model, const Coefficients<S>& a,
                                          const Media<S>& media, const Vec3<S>& point, Vec2<S> start, Trace<S>& trace_out,
                                          Mat2<S>& b_xy) {
  constexpr int kMaxIterations = 20;
  const S tolerance = 64 * std::numeric_limits<S>::epsilon() *
                      (std::abs(point.x()) + std::abs(point.y()) + view.pose.translation.norm());  // mm
  S t = 0;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Eigen::Matrix<S, 3, 2> d_xy;
    const Ray<S> ray = view.ray(start, &d_xy);
    if (auto traced = trace(ray, model, a, media, point.z(), true, trace_out, t); !traced) return traced.error();
    t = trace_out.distance;
    b_xy = trace_out.d_direction * d_xy;
    const Vec2<S> e = trace_out.bottom - point.template head<2>();
    const S det = b_xy(0, 0) * b_xy(1, 1) - b_xy(0, 1) * b_xy(1, 0);
    if (!(std::abs(det) > 0)) return Errc::kSingular;
    if (e.norm() <= tolerance) return start;
    start -= Vec2<S>((b_xy(1, 1) * e.x() - b_xy(0, 1) * e.y()) / det, (b_xy(0, 0) * e.y() - b_xy(1, 0) * e.x()) / det);
  }
  return Errc::kNotConverged;
}

extern template Result<float> intersect(const Ray<float>&, const SurfaceModel<float>&, const Coefficients<float>&, float,
                                        SurfaceSample<float>&);
extern template Result<double> intersect(const Ray<double>&, const SurfaceModel<double>&, const Coefficients<double>&, double,
                                         SurfaceSample<double>&);
extern template Result<void, Errc> trace(const Ray<float>&, const SurfaceModel<float>&, const Coefficients<float>&,
                                         const Media<float>&, float, bool, Trace<float>&, float);
extern template Result<void, Errc> trace(const Ray<double>&, const SurfaceModel<double>&, const Coefficients<double>&,
                                         const Media<double>&, double, bool, Trace<double>&, double);
extern template Result<Vec2<float>> see_through(const View<float>&, const SurfaceModel<float>&, const Coefficients<float>&,
                                                const Media<float>&, const Vec3<float>&, Vec2<float>, Trace<float>&,
                                                Mat2<float>&);
extern template Result<Vec2<double>> see_through(const View<double>&, const SurfaceModel<double>&, const Coefficients<double>&,
                                                 const Media<double>&, const Vec3<double>&, Vec2<double>, Trace<double>&,
                                                 Mat2<double>&);

}  // namespace srd::dsp
