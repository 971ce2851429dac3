// SPDX-License-Identifier: Apache-2.0
// Refraction at one point of the surface by Snell's law, and the way from there through water and floor plates down to the
// pattern, as an offset from the point's foot, so that no digits are lost to the camera's distance. Optics (7), (8).
#pragma once

#include <cmath>

#include "dsp/core/linear_algebra.hpp"
#include "dsp/optics/media.hpp"

namespace srd::dsp {

template <class S>
struct Crossing {
  Vec3<S> normal;           // n, unit, up
  Vec3<S> water_direction;  // v, unit
  Vec2<S> offset;           // b - (p_x, p_y), mm
  // Partial derivatives of the offset; the direction counts as three free numbers.
  Vec2<S> by_height;      // by p_z
  Mat2<S> by_slope;       // by (eta_x, eta_y), mm
  Mat23<S> by_direction;  // by d, mm
  Vec2<S> by_index;       // by the index of water, mm; only when asked for
};

// d: unit direction of the ray in air; zx, zy: slopes at p; height: p_z above the bottom point's plane, mm.
// index_derivative: by_index too; only with derivatives.
// False: the ray comes from below, is totally reflected, or p lies in or under the plates.
template <class S>
[[nodiscard]] bool cross(const Vec3<S>& d, S zx, S zy, S height, const Media<S>& media, bool derivatives, Crossing<S>& out,
                         bool index_derivative = false) {
  const S water_depth = height - media.plates();
  using std::sqrt;
  const S per_m = 1 / sqrt(1 + zx * zx + zy * zy);
  const Vec3<S> n(-zx * per_m, -zy * per_m, per_m);
  const S r = media.air / media.water;
  const S ci = -d.dot(n);
  const S root2 = 1 - r * r * (1 - ci * ci);
  if (!(ci > 0) || !(root2 > 0) || !(water_depth >= 0)) return false;
  const S root = sqrt(root2);
  const S k = r * ci - root;
  const Vec3<S> v = r * d + k * n;  // Snell's law (7)
  if (!(v.z() < 0)) return false;
  const S per_vz = 1 / v.z();
  const S s = -water_depth * per_vz;
  const Vec2<S> lean = v.template head<2>() * per_vz;
  out.normal = n;
  out.water_direction = v;
  out.offset = -water_depth * lean;  // (8)

  // d offset / d v; the first two columns hold the plates' part too.
  Mat2<S> by_v_xy = s * Mat2<S>::Identity();
  // Flat plates keep the horizontal part of index times direction.
  const Vec2<S> horizontal = media.water * v.template head<2>();
  for (int i = 0; i < media.n_layers; ++i) {
    const Layer<S>& layer = media.layers[static_cast<std::size_t>(i)];
    const S c2 = layer.index * layer.index - horizontal.squaredNorm();
    if (!(c2 > 0)) return false;
    const S slowness = layer.thickness / sqrt(c2);
    out.offset += slowness * horizontal;
    if (derivatives) by_v_xy += media.water * slowness * (Mat2<S>::Identity() + horizontal * horizontal.transpose() / c2);
  }
  if (!derivatives) return true;

  const Vec2<S> by_v_z = -s * lean;
  out.by_height = -lean;
  // k depends on ci alone: dv = k dn - dk n (d'dn) at fixed d, and dv = r dd - dk n (n'dd) at fixed n.
  const S dk = r - r * r * ci / root;
  const Vec2<S> by_n = by_v_xy * n.template head<2>() + by_v_z * n.z();
  // n = m/|m|, m = (-eta_x, -eta_y, 1): dn = -(e - n n_e)/|m| for a change of the slope along e.
  for (int axis = 0; axis < 2; ++axis) {
    Vec3<S> dn = (n[axis] * per_m) * n;
    dn[axis] -= per_m;
    out.by_slope.col(axis) = k * (by_v_xy * dn.template head<2>() + by_v_z * dn.z()) - (dk * d.dot(dn)) * by_n;
  }
  out.by_direction.template leftCols<2>() = r * by_v_xy;
  out.by_direction.col(2) = r * by_v_z;
  out.by_direction -= by_n * (dk * n).transpose();
  if (index_derivative) {
    // Through r = air/water, v = r d + k n, and in the plates' horizontal part of index times direction.
    const S per_water = 1 / media.water;
    const Vec3<S> dv = (-r * per_water) * (d + (ci + r * (1 - ci * ci) / root) * n);
    out.by_index = by_v_xy * dv.template head<2>() + by_v_z * dv.z() +
                   (by_v_xy * v.template head<2>() - s * v.template head<2>()) * per_water;
  }
  return true;
}

extern template bool cross(const Vec3<float>&, float, float, float, const Media<float>&, bool, Crossing<float>&, bool);
extern template bool cross(const Vec3<double>&, double, double, double, const Media<double>&, bool, Crossing<double>&, bool);

}  // namespace srd::dsp
