// SPDX-License-Identifier: Apache-2.0
#include "dsp/pose/height_of_pose.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/estimate/solver/cholesky.hpp"
#include "dsp/estimate/solver/rank_report.hpp"

namespace srd::dsp {

double SystematicSurface::deviation_at(const SurfaceModel<double>& model, const Vec2<double>& place) const {
  Basis<double> basis;
  model.basis(place.x(), place.y(), basis);
  return std::sqrt(std::max(0.0, basis.value.dot(covariance.lazyProduct(basis.value).eval())));
}

void SystematicSums::start(int coefficients, int cameras) {
  information_.setZero(coefficients, coefficients);
  n_cameras_ = cameras;
  for (OfCamera& camera : std::span(cameras_).first(static_cast<std::size_t>(cameras))) {
    camera.by_pose.setZero(coefficients, 6);
    camera.by_intrinsics.setZero(coefficients, kMaxIntrinsics);
  }
}

bool SystematicSums::add(std::span<const UnsurePose> cameras, const CountedCorner& corner, const Vec3<double>& point,
                         const WaterAbove& water) {
  const auto camera = static_cast<std::size_t>(corner.camera);
  const View<double>& view = cameras[camera].view;
  const auto seen = see_point(view, point, &water);
  if (!seen) return false;
  const int n = static_cast<int>(information_.rows());
  Basis<double> basis;
  water.model.basis(seen->foot.x(), seen->foot.y(), basis);
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxParameters> j(2, n);
  for (int k = 0; k < n; ++k)
    j.col(k) = seen->by_height * basis.value[k] + seen->by_slope * Vec2<double>(basis.dx[k], basis.dy[k]);
  const double weight = 1 / (corner.sigma * corner.sigma);
  information_.noalias() += weight * j.transpose().lazyProduct(j);
  cameras_[camera].by_pose.noalias() += weight * j.transpose().lazyProduct(seen->by_pose);
  IntrinsicsJacobian by_intrinsics;
  (void)lens_pixel(intrinsics_of(view.camera), seen->normalised, &by_intrinsics, nullptr);
  cameras_[camera].by_intrinsics.noalias() += weight * j.transpose().lazyProduct(by_intrinsics);
  return true;
}

Result<SystematicSurface> SystematicSums::surface(std::span<const UnsurePose> cameras, std::span<const Vec3<double>> points,
                                                  const SurfaceModel<double>& model) const {
  ScaledCholesky factors;
  if (!factors.factor(information_) || !(factors.smallest_pivot() > kRankThreshold)) return Errc::kSingular;
  const InformationMatrix<double> inverse = factors.inverse();
  const Eigen::Index n = information_.rows();
  SystematicSurface out;
  out.covariance = InformationMatrix<double>::Zero(n, n);
  for (std::size_t c = 0; c < static_cast<std::size_t>(n_cameras_); ++c) {
    // -da/dpose, and -da/dcalibration with the pose that follows the calibration.
    const CameraErrors& errors = cameras[c].errors;
    const decltype(OfCamera::by_pose) by_pose = inverse.lazyProduct(cameras_[c].by_pose);
    decltype(OfCamera::by_intrinsics) by_calibration = inverse.lazyProduct(cameras_[c].by_intrinsics);
    by_calibration.noalias() += by_pose.lazyProduct(errors.pose_by_calibration);
    const decltype(OfCamera::by_pose) pose_spread = by_pose.lazyProduct(errors.pose);
    const decltype(OfCamera::by_intrinsics) calibration_spread = by_calibration.lazyProduct(errors.calibration);
    out.covariance.noalias() += pose_spread.lazyProduct(by_pose.transpose());
    out.covariance.noalias() += calibration_spread.lazyProduct(by_calibration.transpose());
  }
  out.deviation = out.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  double squares = 0;
  for (const Vec3<double>& point : points) squares += std::pow(out.deviation_at(model, point.head<2>()), 2);
  out.height_deviation = std::sqrt(squares / static_cast<double>(points.size()));
  if (!std::isfinite(out.height_deviation)) return Errc::kSingular;
  return out;
}

Result<SystematicSurface> surface_of_poses(std::span<const UnsurePose> cameras, std::span<const Vec3<double>> points,
                                           const WaterAbove& water, std::span<const CountedCorner> corners) {
  if (cameras.empty() || cameras.size() > kMaxUnsureCameras || corners.empty()) return Errc::kInvalidArgument;
  SystematicSums sums;
  sums.start(water.model.modes.size(), static_cast<int>(cameras.size()));
  for (const CountedCorner& corner : corners)
    if (!sums.add(cameras, corner, points[static_cast<std::size_t>(corner.point)], water)) return Errc::kOutOfDomain;
  return sums.surface(cameras, points, water.model);
}

}  // namespace srd::dsp
