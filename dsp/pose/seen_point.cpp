// SPDX-License-Identifier: Apache-2.0
#include "dsp/pose/seen_point.hpp"

#include <Eigen/Geometry>

namespace srd::dsp {

namespace {

Mat3<double> cross_matrix(const Vec3<double>& v) {
  Mat3<double> m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Seen through air: x_C = R X + T moves by w x R X + t.
Result<SeenPoint> see_directly(const View<double>& view, const Vec3<double>& point) {
  const Vec3<double> turned = view.pose.rotation * point;
  const Vec3<double> c = turned + view.pose.translation;
  if (!(c.z() > 0)) return Errc::kOutOfDomain;
  const Vec2<double> xy(c.x() / c.z(), c.y() / c.z());
  Mat2<double> by_xy;
  SeenPoint seen;
  seen.pixel = view.camera.pixel(xy, &by_xy);
  seen.normalised = xy;
  Mat23<double> by_c;
  by_c << 1 / c.z(), 0, -xy.x() / c.z(), 0, 1 / c.z(), -xy.y() / c.z();
  const Mat23<double> by_t = by_xy * by_c;
  seen.by_pose.leftCols<3>() = -by_t * cross_matrix(turned);
  seen.by_pose.rightCols<3>() = by_t;
  return seen;
}

}  // namespace

Pose<double> changed(const Pose<double>& pose, const PoseChange& change) {
  const Vec3<double> w = change.head<3>();
  const double angle = w.norm();
  Pose<double> out = pose;
  out.translation += change.tail<3>();
  if (angle > 0) out.rotation = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() * pose.rotation;
  return out;
}

PoseChange change_between(const Pose<double>& from, const Pose<double>& to) {
  PoseChange change;
  const Eigen::AngleAxisd turn(Mat3<double>(to.rotation * from.rotation.transpose()));
  change << turn.angle() * turn.axis(), to.translation - from.translation;
  return change;
}

Eigen::Matrix<double, 3, 6> centre_by_change(const Pose<double>& pose) {
  Eigen::Matrix<double, 3, 6> by;
  by << -pose.rotation.transpose() * cross_matrix(pose.translation), -pose.rotation.transpose();
  return by;
}

Result<SeenPoint> see_point(const View<double>& view, const Vec3<double>& point, const WaterAbove* water) {
  if (water == nullptr) return see_directly(view, point);
  // Water lifts what lies under it: the point at its apparent height is near where the ray leaves for.
  const double level = water->model.height(water->surface, point.x(), point.y());
  const Vec3<double> lifted = point + (level - point.z()) * (1 - water->media.air / water->media.water) * Vec3<double>::UnitZ();
  const auto start = view.normalised(lifted);
  if (!start) return start.error();
  Trace<double> ray;
  Mat2<double> b_xy, xy_b, pixel_xy;
  const auto xy = see_through(view, water->model, water->surface, water->media, point, *start, ray, b_xy);
  if (!xy) return xy.error();
  if (!invert(b_xy, xy_b)) return Errc::kSingular;
  SeenPoint seen;
  seen.pixel = view.camera.pixel(*xy, &pixel_xy);
  seen.normalised = *xy;
  // b stays at the point: q moves by -(dq/db) of what the other changes do to b.
  const Mat2<double> back = -pixel_xy * xy_b;
  seen.by_height = back * ray.d_height;
  seen.by_slope = back * ray.d_slope;
  seen.foot = ray.surface_point.head<2>();

  const Vec3<double> u = Vec3<double>(xy->x(), xy->y(), 1).normalized();
  const Vec3<double> d = view.pose.rotation.transpose() * u;
  const SurfaceSample<double> at = water->model.sample(water->surface, seen.foot.x(), seen.foot.y());
  const Vec3<double> m(-at.zx, -at.zy, 1);
  const Mat3<double> along_surface = Mat3<double>::Identity() - d * m.transpose() / m.dot(d);
  Mat23<double> by_surface_point;
  by_surface_point << Mat2<double>::Identity(), -ray.water_direction.head<2>() / ray.water_direction.z();
  Mat2<double> curvature;
  curvature << at.zxx, at.zxy, at.zxy, at.zyy;
  const Mat23<double> by_centre = by_surface_point * along_surface + ray.d_slope * (curvature * along_surface.topRows<2>());
  Eigen::Matrix<double, 2, 6> b_pose = by_centre * centre_by_change(view.pose);
  b_pose.leftCols<3>() += ray.d_direction * (view.pose.rotation.transpose() * cross_matrix(u));
  seen.by_pose = back * b_pose;
  return seen;
}

}  // namespace srd::dsp
