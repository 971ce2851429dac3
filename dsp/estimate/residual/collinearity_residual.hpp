// SPDX-License-Identifier: Apache-2.0
// Normal collinearity: the normal that would send the measured ray to its bottom point against the surface's own.
// Optics (10), with floor plates.
#pragma once

#include <cmath>
#include <limits>

#include "dsp/core/lanes.hpp"
#include "dsp/estimate/residual/local_residual.hpp"
#include "dsp/optics/media.hpp"

namespace srd::dsp {

// The straight way from a point of the surface down to F: w, its direction in the water, and dw/dp.
template <class S>
struct WaterWay {
  Vec3<S> w;         // unit, down
  Mat3<S> by_p;      // 1/mm
  Vec3<S> by_index;  // dw by the index of water
};

// foot, height: p - F, mm. False: p lies in or under the plates, or the plates let no such ray through.
template <class S>
[[nodiscard]] bool water_way(const Vec2<S>& foot, S height, const Media<S>& media, WaterWay<S>& out) {
  using std::sqrt;
  const S depth = height - media.plates();
  if (!(depth > 0)) return false;
  // Horizontal part of index times direction, one for all media: -foot = h kappa(h'h), by Newton from the solution
  // for plates of water.
  Vec2<S> h = -foot * (media.water / sqrt(foot.squaredNorm() + height * height));
  Mat2<S> inverse;
  S c = 0;
  bool found = false;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const S h2 = h.squaredNorm();
    const S c2 = media.water * media.water - h2;
    if (!(c2 > 0)) return false;
    c = sqrt(c2);
    S kappa = depth / c, kappa_h = kappa / c2;
    for (int i = 0; i < media.n_layers; ++i) {
      const Layer<S>& layer = media.layers[static_cast<std::size_t>(i)];
      const S plate2 = layer.index * layer.index - h2;
      if (!(plate2 > 0)) return false;
      const S part = layer.thickness / sqrt(plate2);
      kappa += part;
      kappa_h += part / plate2;
    }
    // (kappa I + kappa_h h h')^-1
    inverse = (Mat2<S>::Identity() - h * h.transpose() * (kappa_h / (kappa + kappa_h * h2))) / kappa;
    if (found || media.n_layers == 0) {
      found = true;
      break;
    }
    const Vec2<S> step = -(inverse * (kappa * h + foot));
    h += step;
    found = step.norm() <= 64 * std::numeric_limits<typename LaneOf<S>::Type>::epsilon();
  }
  if (!found) return false;
  out.w << h / media.water, -c / media.water;
  Mat23<S> by_p;
  by_p << -inverse, -(inverse * h) / c;
  by_p /= media.water;
  out.by_p.template topRows<2>() = by_p;
  out.by_p.row(2) = -(out.w.template head<2>().transpose() * by_p) / out.w.z();
  const Vec2<S> h_index = (inverse * h) * (depth * media.water / (c * c * c));
  const Vec2<S> level = (h_index - out.w.template head<2>()) / media.water;
  out.by_index << level, -out.w.template head<2>().dot(level) / out.w.z();
  return true;
}

// e: n2 - n in the plane square to n2 + n, turned with it to the horizontal, so that |e| = |n2 - n| exactly; rad for
// small e. d: measured ray; foot, height: p - F, mm; zx, zy: slopes at p.
template <class S>
[[nodiscard]] bool collinearity_residual(const Vec3<S>& d, const Vec2<S>& foot, S height, S zx, S zy, const Media<S>& media,
                                         LocalResidual<S>& out) {
  using std::copysign;
  using std::isfinite;
  using std::sqrt;
  WaterWay<S> way;
  if (!water_way(foot, height, media, way)) return false;
  const S ratio = media.water / media.air;
  Vec3<S> u = d - ratio * way.w;
  const S per_u = copysign(1 / u.norm(), u.z());
  const Vec3<S> n2 = per_u * u;
  const S per_m = 1 / sqrt(1 + zx * zx + zy * zy);
  const Vec3<S> n(-zx * per_m, -zy * per_m, per_m);
  const Vec3<S> sum = n + n2, difference = n2 - n;
  const S length = sum.norm();
  const S q = length + sum.z();
  if (!isfinite(per_u) || !(q > 0)) return false;
  const S lift = difference.z() / q;
  out.e = difference.template head<2>() - lift * sum.template head<2>();

  Mat23<S> by_difference, by_sum;
  by_difference << Mat2<S>::Identity(), -sum.template head<2>() / q;
  by_sum = sum.template head<2>() * ((lift / q) * (sum / length + Vec3<S>::UnitZ())).transpose();
  by_sum.template leftCols<2>() -= lift * Mat2<S>::Identity();
  const Mat23<S> by_n2 = by_sum + by_difference, by_n = by_sum - by_difference;
  out.by_d = per_u * (by_n2 - (by_n2 * n2) * n2.transpose());
  out.by_p = -ratio * (out.by_d * way.by_p);
  out.by_index = -(out.by_d * (way.w / media.air + ratio * way.by_index));
  for (int axis = 0; axis < 2; ++axis) {
    Vec3<S> dn = (n[axis] * per_m) * n;
    dn[axis] -= per_m;
    out.by_slope.col(axis) = by_n * dn;
  }
  return true;
}

}  // namespace srd::dsp
