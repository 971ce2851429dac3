// SPDX-License-Identifier: Apache-2.0
#include "dsp/pose/height_of_pose.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/estimate/solver/cholesky.hpp"
#include "dsp/estimate/solver/rank_report.hpp"

namespace srd::dsp {

Result<SystematicSurface> surface_of_poses(std::span<const UnsurePose> cameras, std::span<const Vec3<double>> points,
                                           const WaterAbove& water, std::span<const CountedCorner> corners) {
  if (cameras.empty() || cameras.size() > kMaxUnsureCameras || corners.empty()) return Errc::kInvalidArgument;
  using Rows = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxParameters>;
  using Mixed = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxParameters, 6>;
  const int n = water.model.modes.size();
  InformationMatrix<double> h = InformationMatrix<double>::Zero(n, n);
  std::array<Mixed, kMaxUnsureCameras> mixed;
  for (Mixed& m : mixed) m = Mixed::Zero(n, 6);
  Basis<double> basis;
  Rows j(2, n);
  for (const CountedCorner& corner : corners) {
    const auto camera = static_cast<std::size_t>(corner.camera);
    const auto seen = see_point(cameras[camera].view, points[static_cast<std::size_t>(corner.point)], &water);
    if (!seen) return seen.error();
    water.model.basis(seen->foot.x(), seen->foot.y(), basis);
    for (int k = 0; k < n; ++k)
      j.col(k) = seen->by_height * basis.value[k] + seen->by_slope * Vec2<double>(basis.dx[k], basis.dy[k]);
    const double weight = 1 / (corner.sigma * corner.sigma);
    h.noalias() += weight * j.transpose().lazyProduct(j);
    mixed[camera].noalias() += weight * j.transpose().lazyProduct(seen->by_pose);
  }
  ScaledCholesky factors;
  if (!factors.factor(h) || !(factors.smallest_pivot() > kRankThreshold)) return Errc::kSingular;
  const InformationMatrix<double> inverse = factors.inverse();
  SystematicSurface out;
  out.covariance = InformationMatrix<double>::Zero(n, n);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Mixed by_pose = inverse.lazyProduct(mixed[c]);  // -da/dpose
    const Mixed spread = by_pose.lazyProduct(cameras[c].covariance);
    out.covariance.noalias() += spread.lazyProduct(by_pose.transpose());
  }
  out.deviation = out.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  double squares = 0;
  for (const Vec3<double>& point : points) {
    water.model.basis(point.x(), point.y(), basis);
    squares += basis.value.dot(out.covariance.lazyProduct(basis.value).eval());
  }
  out.height_deviation = std::sqrt(std::max(0.0, squares / static_cast<double>(points.size())));
  if (!std::isfinite(out.height_deviation)) return Errc::kSingular;
  return out;
}

}  // namespace srd::dsp
