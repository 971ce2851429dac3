// SPDX-License-Identifier: Apache-2.0
// Residuals of one corner along its measured ray: on the bottom plane, mm (9), or between normals, rad (10).
#pragma once

#include "dsp/estimate/residual/collinearity_residual.hpp"
#include "dsp/estimate/residual/corner_residual.hpp"
#include "dsp/estimate/residual/disparity_residual.hpp"
#include "dsp/estimate/residual/metric.hpp"
#include "dsp/estimate/residual/prepared_corner.hpp"

namespace srd::dsp {

// metric: disparity or collinearity. corner.along: start and result. basis as in reprojection_residual; pixel_e, when wanted: de/dq at fixed surface.
// False: the ray misses the surface from above, or the residual does not exist there.
template <class S>
[[nodiscard]] bool ray_residual(Metric metric, const Optics<S>& optics, const Coefficients<S>& a, PreparedCorner<S>& corner,
                                Basis<S>* basis, CornerResidual<S>& out, Mat2<S>* pixel_e = nullptr) {
  constexpr int kMaxIterations = 30;
  using std::abs;
  using std::isfinite;
  const Vec3<S>& d = corner.direction;
  S along = corner.along;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Vec2<S> foot = corner.dry + along * d.template head<2>();
    SurfaceSample<S> at = optics.model.evaluate(&a, corner.point.x() + foot.x(), corner.point.y() + foot.y(), basis);
    const S slope = d.z() - at.zx * d.x() - at.zy * d.y();
    if (!(slope < 0)) return false;                                       // grazing or leaving: not a view from above
    const S step = -(along * d.z() - (at.z - corner.point.z())) / slope;  // (6)
    if (!isfinite(step)) return false;
    along += step;
    if (!(abs(step) <= optics.last_step)) continue;
    if (!(corner.dry_distance + along > 0)) return false;

    corner.along = along;
    const Vec2<S> moved = step * d.template head<2>();
    foot += moved;
    at.zx += at.zxx * moved.x() + at.zxy * moved.y();
    at.zy += at.zxy * moved.x() + at.zyy * moved.y();
    LocalResidual<S> local;
    const bool valid = metric == Metric::kDisparity
                           ? disparity_residual(d, foot, along * d.z(), at.zx, at.zy, optics.media, local, optics.free_index)
                           : collinearity_residual(d, foot, along * d.z(), at.zx, at.zy, optics.media, local);
    if (!valid) return false;
    out.e = local.e;
    if (basis == nullptr) return true;

    Mat2<S> curvature;
    curvature << at.zxx, at.zxy, at.zxy, at.zyy;
    // A raised surface moves p by d/h along the ray (13), and with it the slopes by their curvature (14).
    Mat23<S> by_p = local.by_p;
    by_p.template leftCols<2>() += local.by_slope * curvature;
    out.by_height = by_p * d / slope;
    out.by_slope = local.by_slope;
    if (optics.free_index) out.by_index = local.by_index;
    if (pixel_e == nullptr) return true;
    // A turned ray: dp = t dd + d dt with m'dp = 0.
    const S t = corner.dry_distance + along;
    const Vec3<S> m(-at.zx, -at.zy, 1);
    const Mat23<S> by_direction = local.by_d + t * (by_p - (by_p * d / slope) * m.transpose());
    Eigen::Matrix<S, 3, 2> d_seen;
    (void)corner.view->ray(corner.normalised, &d_seen);
    Mat2<S> pixel_seen;
    (void)corner.view->camera.pixel(corner.normalised, &pixel_seen);
    Mat2<S> seen_pixel;
    if (!invert(pixel_seen, seen_pixel)) return false;
    *pixel_e = (by_direction * d_seen) * seen_pixel;
    return true;
  }
  return false;
}

extern template bool ray_residual(Metric, const Optics<Lanes<float>>&, const Coefficients<Lanes<float>>&,
                                  PreparedCorner<Lanes<float>>&, Basis<Lanes<float>>*, CornerResidual<Lanes<float>>&,
                                  Mat2<Lanes<float>>*);
extern template bool ray_residual(Metric, const Optics<Lanes<double>>&, const Coefficients<Lanes<double>>&,
                                  PreparedCorner<Lanes<double>>&, Basis<Lanes<double>>*, CornerResidual<Lanes<double>>&,
                                  Mat2<Lanes<double>>*);

}  // namespace srd::dsp
