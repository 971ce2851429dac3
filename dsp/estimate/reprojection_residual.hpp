// Residual of one corner in the raw image, px, exact. Optics (11).
// The unknown of the inner Newton iteration is the foot of the surface point through which the camera sees F: one
// evaluation of the surface a step, plates included, and no difference of large numbers.
#pragma once

#include "dsp/estimate/corner_residual.hpp"
#include "dsp/estimate/prepared_corner.hpp"

namespace srd::dsp {

// corner.foot: start and result. basis: filled at the surface point, unless null; then by_height, by_slope stay unset.
// False: no ray from the camera through this surface reaches F, or Newton does not find it.
template <class S>
[[nodiscard]] bool reprojection_residual(const Optics<S>& optics, const Coefficients<S>& a, PreparedCorner<S>& corner,
                                         Basis<S>* basis, CornerResidual<S>& out) {
  constexpr int kMaxIterations = 25;
  using std::isfinite;
  Vec2<S> foot = corner.foot;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const SurfaceSample<S> at =
        optics.model.evaluate(&a, corner.point.x() + foot.x(), corner.point.y() + foot.y(), basis);
    const S height = at.z - corner.point.z();
    const Vec3<S> from_camera(foot.x() - corner.camera_from_point.x(), foot.y() - corner.camera_from_point.y(),
                              height - corner.camera_from_point.z());
    const S per_distance = 1 / from_camera.norm();
    const Vec3<S> d = from_camera * per_distance;
    Crossing<S> crossing;
    if (!cross(d, at.zx, at.zy, height, optics.media, true, crossing, optics.free_index)) return false;
    // dd = (I - d d')/t dp, so d offset/dp through the direction, for p = (foot, height):
    const Mat23<S> by_p = (crossing.by_direction - (crossing.by_direction * d) * d.transpose()) * per_distance;
    const Vec2<S> by_height = crossing.by_height + by_p.col(2);
    Mat2<S> curvature;
    curvature << at.zxx, at.zxy, at.zxy, at.zyy;
    Mat2<S> b_foot = Mat2<S>::Identity() + by_p.template leftCols<2>() + crossing.by_slope * curvature;
    b_foot.col(0) += by_height * at.zx;
    b_foot.col(1) += by_height * at.zy;
    Mat2<S> inverse;
    if (!invert(b_foot, inverse)) return false;
    const Vec2<S> step = -(inverse * (foot + crossing.offset));
    const S size = step.norm();
    if (!isfinite(size)) return false;
    foot += step;
    if (!(size <= optics.last_step)) continue;

    corner.foot = foot;
    const S rise = (at.zx + S(0.5) * (at.zxx * step.x() + at.zxy * step.y())) * step.x() +
                   (at.zy + S(0.5) * (at.zxy * step.x() + at.zyy * step.y())) * step.y();
    const Mat3<S>& rotation = corner.view->pose.rotation;
    const Vec3<S> in_camera = corner.point_in_camera + rotation * Vec3<S>(foot.x(), foot.y(), height + rise);
    if (!(in_camera.z() > 0)) return false;
    const S per_z = 1 / in_camera.z();
    const Vec2<S> seen(in_camera.x() * per_z, in_camera.y() * per_z);
    if (basis == nullptr) {
      out.e = corner.view->camera.pixel(seen) - corner.pixel;
      return true;
    }
    Mat2<S> pixel_seen;
    out.e = corner.view->camera.pixel(seen, &pixel_seen) - corner.pixel;
    const Mat23<S> pixel_p = (pixel_seen * per_z) * (rotation.template topRows<2>() - seen * rotation.row(2));
    Mat2<S> pixel_foot = pixel_p.template leftCols<2>();
    pixel_foot.col(0) += pixel_p.col(2) * at.zx;
    pixel_foot.col(1) += pixel_p.col(2) * at.zy;
    // b(foot, a) = F stays true when a changes: dfoot/da_j = -b_foot^-1 (by_height phi_j + by_slope grad phi_j).
    const Mat2<S> e_b = -(pixel_foot * inverse);
    out.by_height = pixel_p.col(2) + e_b * by_height;
    out.by_slope = e_b * crossing.by_slope;
    if (optics.free_index) out.by_index = e_b * crossing.by_index;
    return true;
  }
  return false;
}

}  // namespace srd::dsp
