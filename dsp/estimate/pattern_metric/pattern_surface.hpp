// SPDX-License-Identifier: Apache-2.0
// The surfaces that the pattern metric can fit: a sum of modes (5), or the two-parameter form of OpenSRD's release of
// 2017. Both give the way of a ray and its derivatives in the same six numbers.
#pragma once

#include "dsp/optics/ray_trace.hpp"

namespace srd::dsp {

enum class SurfaceForm : unsigned char {
  kModes,
  // (c0, c1): a level surface z = c0 mm where the rays meet it, refracting with the normal (-c1/100, 0.07, 1). It stands
  // for a small piece of a wave; as a surface it contradicts itself and is there to compare with published results.
  kLevelAndNormal,
};

inline constexpr double kNormalScale = 100;  // of c1
inline constexpr double kNormalY = 0.07;     // second component of the fixed normal

struct PatternSurface {
  SurfaceForm form = SurfaceForm::kModes;
  SurfaceModel<double> model;  // kModes only

  [[nodiscard]] int parameters() const { return form == SurfaceForm::kModes ? model.modes.size() : 2; }

  // dt: start distance along the ray, <= 0: none. As trace() of optics/ray_trace.hpp, d_direction included.
  [[nodiscard]] Result<void, Errc> follow(const Ray<double>& ray, const Coefficients<double>& a, const Media<double>& media,
                                          double bottom_z, Trace<double>& out, double start) const {
    if (form == SurfaceForm::kModes) return trace(ray, model, a, media, bottom_z, true, out, start);
    const Vec3<double>& d = ray.direction;
    if (!(d.z() < 0)) return Errc::kOutOfDomain;
    out.distance = (a[0] - ray.origin.z()) / d.z();
    if (!(out.distance > 0)) return Errc::kOutOfDomain;
    out.surface_point = ray.origin + out.distance * d;
    Crossing<double> crossing;
    if (!cross(d, a[1] / kNormalScale, -kNormalY, a[0] - bottom_z, media, true, crossing)) return Errc::kOutOfDomain;
    out.normal = crossing.normal;
    out.water_direction = crossing.water_direction;
    out.bottom = out.surface_point.head<2>() + crossing.offset;
    out.d_slope = crossing.by_slope;
    out.d_height = d.head<2>() / d.z() + crossing.by_height;
    out.d_direction = crossing.by_direction;
    out.d_direction.leftCols<2>() += out.distance * Mat2<double>::Identity();
    out.d_direction.col(2) -= out.distance * d.head<2>() / d.z();
    return {};
  }

  // phi_j and its slopes at a surface point: db/da_j = d_height phi_j + d_slope (phi_j,x , phi_j,y).
  void basis(const Vec3<double>& surface_point, Basis<double>& out) const {
    if (form == SurfaceForm::kModes) {
      model.basis(surface_point.x(), surface_point.y(), out);
      return;
    }
    out.value = out.dx = out.dy = Coefficients<double>::Zero(2);
    out.value[0] = 1;
    out.dx[1] = 1 / kNormalScale;
  }
};

}  // namespace srd::dsp
