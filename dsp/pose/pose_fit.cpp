// SPDX-License-Identifier: Apache-2.0
#include "dsp/pose/pose_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace srd::dsp {

namespace {

constexpr int kMaxTrials = 60;
constexpr double kMaxDamping = 1e12;
// A step whose promised fall is this part of the cost moves the pose by 1e-6 of its deviation.
constexpr double kPromiseOfCost = 1e-14;
// Of the information scaled to unit diagonal; as for a surface's coefficients.
constexpr double kMinPivot = 1e-12;

struct PoseSums {
  PoseMatrix h = PoseMatrix::Zero();
  PoseChange g = PoseChange::Zero();      // J'We
  PoseChange level = PoseChange::Zero();  // J'W de/dlevel
  double cost = 0;
  double rounding = 0;  // of the cost
};

Result<PoseSums> sums_at(const CameraModel<double>& camera, const Pose<double>& pose, std::span<const PoseCorner> corners,
                         const WaterAbove* water) {
  const View<double> view{camera, pose};
  PoseSums sums;
  for (const PoseCorner& corner : corners) {
    const auto seen = see_point(view, corner.point, water);
    if (!seen) return seen.error();
    const double weight = 1 / (corner.sigma * corner.sigma);
    const Vec2<double> e = seen->pixel - corner.pixel;
    sums.h += weight * seen->by_pose.transpose() * seen->by_pose;
    sums.g += weight * seen->by_pose.transpose() * e;
    sums.level += weight * seen->by_pose.transpose() * seen->by_height;
    sums.cost += weight * e.squaredNorm();
    const double eps = 1e-13 * (corner.pixel.norm() + 1);
    sums.rounding += weight * eps * (eps + e.norm());
  }
  return sums;
}

// J'W dq/d(intrinsics)
Result<PoseByIntrinsics> information_by_intrinsics(const View<double>& view, std::span<const PoseCorner> corners,
                                                   const WaterAbove* water) {
  const auto intrinsics = intrinsics_of(view.camera);
  PoseByIntrinsics sum = PoseByIntrinsics::Zero();
  for (const PoseCorner& corner : corners) {
    const auto seen = see_point(view, corner.point, water);
    if (!seen) return seen.error();
    IntrinsicsJacobian q;
    (void)lens_pixel(intrinsics, seen->normalised, &q, nullptr);
    sum += (1 / (corner.sigma * corner.sigma)) * seen->by_pose.transpose() * q;
  }
  return sum;
}

// Turns and shifts have different units: pivots are compared at unit diagonal.
bool solve_scaled(const PoseMatrix& h, double damping, const PoseChange& g, PoseChange& step) {
  const PoseChange root = h.diagonal().cwiseSqrt();
  if (!(root.minCoeff() > 0)) return false;
  const PoseChange per = root.cwiseInverse();
  PoseMatrix scaled = per.asDiagonal() * h * per.asDiagonal();
  scaled.diagonal().array() += damping;
  const Eigen::LDLT<PoseMatrix> factors(scaled);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > kMinPivot)) return false;
  step = -per.cwiseProduct(factors.solve(per.cwiseProduct(g)));
  return step.allFinite();
}

}  // namespace

Result<PoseEstimate> fit_pose_to(const CameraModel<double>& camera, const Pose<double>& start,
                                 std::span<const PoseCorner> corners, const WaterAbove* water) {
  if (corners.size() < 3) return Errc::kInvalidArgument;
  for (const PoseCorner& corner : corners)
    if (!(corner.sigma > 0) || !corner.pixel.allFinite() || !corner.point.allFinite()) return Errc::kInvalidArgument;
  Pose<double> pose = start;
  auto sums = sums_at(camera, pose, corners, water);
  if (!sums) return sums.error();
  double damping = 0;
  bool done = false;
  for (int trial = 0; trial < kMaxTrials && !done; ++trial) {
    PoseChange step;
    if (!solve_scaled(sums->h, damping, sums->g, step)) return Errc::kSingular;
    const double promised = -step.dot(sums->g);
    done = damping == 0 && promised <= kPromiseOfCost * sums->cost + sums->rounding;
    const Pose<double> there = changed(pose, step);
    auto next = sums_at(camera, there, corners, water);
    if (next && next->cost <= sums->cost + sums->rounding) {
      pose = there;
      sums = next;
      damping = damping < 1e-6 ? 0 : damping / 10;
    } else if (!done) {
      damping = std::max(1e-4, damping * 10);
      if (damping > kMaxDamping) break;
    }
  }
  if (!done) return Errc::kNotConverged;

  PoseEstimate estimate;
  estimate.pose = pose;
  const auto by_intrinsics = information_by_intrinsics({camera, pose}, corners, water);
  if (!by_intrinsics) return by_intrinsics.error();
  estimate.corners = static_cast<int>(corners.size());
  estimate.cost = sums->cost;
  for (int i = 0; i < 6; ++i) {
    PoseChange column;
    if (!solve_scaled(sums->h, 0, -PoseChange::Unit(i), column)) return Errc::kSingular;
    estimate.cofactor.col(i) = column;
  }
  estimate.cofactor = (estimate.cofactor + estimate.cofactor.transpose()).eval() / 2;
  estimate.by_level = -estimate.cofactor * sums->level;
  estimate.by_intrinsics = -estimate.cofactor * *by_intrinsics;
  if (corners.size() > 3) estimate.variance_factor = sums->cost / (2.0 * static_cast<double>(corners.size()) - 6);
  return estimate;
}

}  // namespace srd::dsp
