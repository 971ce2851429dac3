// SPDX-License-Identifier: Apache-2.0
// Where a camera sees a bottom point through the surface, and how that moves with the point and with the surface. T is a
// scalar, or Lanes of it for several points at once. Optics (8), inverted.
// The unknown of the Newton iteration is the foot of the surface point through which the camera sees F: one evaluation of
// the surface a step, plates included, and no difference of large numbers.
#pragma once

#include <algorithm>
#include <cmath>

#include "dsp/core/linear_algebra.hpp"
#include "dsp/optics/refraction.hpp"
#include "dsp/optics/surface_model.hpp"
#include "dsp/optics/view.hpp"

namespace srd::dsp {

// What all points of an evaluation share.
template <class T>
struct Optics {
  SurfaceModel<T> model;
  Media<T> media;
  // A step shorter than this, mm, is the last one: what it leaves is below 1e-10 mm (double) or 1e-4 mm (float).
  T last_step = 0;
  bool free_index = false;  // the index of water is estimated too: residuals give their derivative by it

  template <class S>
  static Optics make(const SurfaceModel<S>& model, const Media<S>& media) {
    return make(model, media, sizeof(S) > sizeof(float) ? 1e-10 : 1e-4);
  }
  // error: of a foot, mm, that needs no further step. After a step of x, Newton's is x^2 times half the curvature of the way
  // from foot to bottom. That is a quarter of the depth (refraction) times the slopes times the square of the wave number:
  // with 200 mm and 0.25, 6 k^2; and 1/1000 mm for a camera a metre away.
  template <class S>
  static Optics make(const SurfaceModel<S>& model, const Media<S>& media, double error) {
    const double k = M_PI * std::max(model.modes.highest_x() / static_cast<double>(model.lx),
                                     model.modes.highest_y() / static_cast<double>(model.ly));
    return {model.template cast<T>(), media.template cast<T>(), static_cast<T>(std::sqrt(error / (6 * k * k + 1e-3))), false};
  }
};

// A bottom point before a camera; everything relative to the point, so that float keeps micrometres at a metre.
template <class T>
struct SightLine {
  Vec3<T> point;              // F, mm, W
  Vec3<T> camera_from_point;  // c - F, mm
  Vec3<T> point_in_camera;    // R F + T, mm
  Vec2<T> foot;               // of the surface point, from F, mm: where the iteration starts, and where it ended
  const View<T>* view = nullptr;
};

template <class T>
struct Sighting {
  Vec2<T> seen;         // normalised, undistorted
  Vec2<T> pixel;        // raw px
  Mat2<T> pixel_point;  // d pixel / d (F_x, F_y), px/mm
  Vec2<T> by_height;    // d pixel / d a_j = by_height phi_j + by_slope grad phi_j, the modes taken at the surface point
  Mat2<T> by_slope;
  Vec2<T> by_index;  // d pixel / d index of water; with Optics::free_index
};

// line.foot: start and result. basis: filled at the surface point, unless null.
// derivatives: fill what follows the pixel in the result too.
// False: no ray from the camera through this surface reaches F, or Newton does not find it.
template <class T>
[[nodiscard]] bool sight(const Optics<T>& optics, const Coefficients<T>& a, SightLine<T>& line, Basis<T>* basis,
                         bool derivatives, Sighting<T>& out) {
  constexpr int kMaxIterations = 25;
  using std::isfinite;
  Vec2<T> foot = line.foot;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const SurfaceSample<T> at = optics.model.evaluate(&a, line.point.x() + foot.x(), line.point.y() + foot.y(), basis);
    const T height = at.z - line.point.z();
    const Vec3<T> from_camera(foot.x() - line.camera_from_point.x(), foot.y() - line.camera_from_point.y(),
                              height - line.camera_from_point.z());
    const T per_distance = 1 / from_camera.norm();
    const Vec3<T> d = from_camera * per_distance;
    Crossing<T> crossing;
    if (!cross(d, at.zx, at.zy, height, optics.media, true, crossing, optics.free_index)) return false;
    // dd = (I - d d')/t dp, so d offset/dp through the direction, for p = (foot, height):
    const Mat23<T> by_p = (crossing.by_direction - (crossing.by_direction * d) * d.transpose()) * per_distance;
    const Vec2<T> by_height = crossing.by_height + by_p.col(2);
    Mat2<T> curvature;
    curvature << at.zxx, at.zxy, at.zxy, at.zyy;
    Mat2<T> b_foot = Mat2<T>::Identity() + by_p.template leftCols<2>() + crossing.by_slope * curvature;
    b_foot.col(0) += by_height * at.zx;
    b_foot.col(1) += by_height * at.zy;
    Mat2<T> inverse;
    if (!invert(b_foot, inverse)) return false;
    const Vec2<T> step = -(inverse * (foot + crossing.offset));
    const T size = step.norm();
    if (!isfinite(size)) return false;
    foot += step;
    if (!(size <= optics.last_step)) continue;

    line.foot = foot;
    const T rise = (at.zx + T(0.5) * (at.zxx * step.x() + at.zxy * step.y())) * step.x() +
                   (at.zy + T(0.5) * (at.zxy * step.x() + at.zyy * step.y())) * step.y();
    const Mat3<T>& rotation = line.view->pose.rotation;
    const Vec3<T> in_camera = line.point_in_camera + rotation * Vec3<T>(foot.x(), foot.y(), height + rise);
    if (!(in_camera.z() > 0)) return false;
    const T per_z = 1 / in_camera.z();
    out.seen = Vec2<T>(in_camera.x() * per_z, in_camera.y() * per_z);
    if (!derivatives) {
      out.pixel = line.view->camera.pixel(out.seen);
      return true;
    }
    Mat2<T> pixel_seen;
    out.pixel = line.view->camera.pixel(out.seen, &pixel_seen);
    const Mat23<T> pixel_p = (pixel_seen * per_z) * (rotation.template topRows<2>() - out.seen * rotation.row(2));
    Mat2<T> pixel_foot = pixel_p.template leftCols<2>();
    pixel_foot.col(0) += pixel_p.col(2) * at.zx;
    pixel_foot.col(1) += pixel_p.col(2) * at.zy;
    // b(foot, a) = F stays true when F or a changes: d(F + foot)/dF = b_foot^-1, and
    // dfoot/da_j = -b_foot^-1 (by_height phi_j + by_slope grad phi_j).
    out.pixel_point = pixel_foot * inverse;
    out.by_height = pixel_p.col(2) - out.pixel_point * by_height;
    out.by_slope = -(out.pixel_point * crossing.by_slope);
    if (optics.free_index) out.by_index = -(out.pixel_point * crossing.by_index);
    return true;
  }
  return false;
}

// Compiled once: it is most of what a fit and a prediction do.
extern template bool sight(const Optics<Lanes<float>>&, const Coefficients<Lanes<float>>&, SightLine<Lanes<float>>&,
                           Basis<Lanes<float>>*, bool, Sighting<Lanes<float>>&);
extern template bool sight(const Optics<Lanes<double>>&, const Coefficients<Lanes<double>>&, SightLine<Lanes<double>>&,
                           Basis<Lanes<double>>*, bool, Sighting<Lanes<double>>&);

}  // namespace srd::dsp
