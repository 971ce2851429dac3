// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/projection_uncertainty.hpp"

#include <cmath>
#include <limits>

#include "dsp/optics/camera_model.hpp"
#include "host/bundle/lens.hpp"

namespace srd::bundle {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Optics (32): q = project(lens, mean over the boards of where the point is that each of them holds).
double deviation_at(const CameraFit& fit, const dsp::CameraModel<double>& camera, double u, double v, double distance_mm) {
  const auto ray = camera.undistort({u, v});
  if (!ray) return kNone;
  const Eigen::Vector3d point = Eigen::Vector3d(ray->x(), ray->y(), 1).normalized() * distance_mm;
  IntrinsicsJacobian by_lens;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Vector2d pixel;
  if (!project(fit.intrinsics, point, pixel, &by_lens, &by_point)) return kNone;
  const int n = fit.board_at();
  Eigen::Matrix<double, 2, Eigen::Dynamic> j = Eigen::MatrixXd::Zero(2, n);
  j.leftCols(fit.lens_size()) = by_lens.leftCols(fit.lens_size());
  const double part = 1.0 / static_cast<double>(fit.views.size());
  for (std::size_t i = 0; i < fit.views.size(); ++i) {
    const PoseVector& pose = fit.views[i].pose;
    const Turn turn(pose.head<3>());
    j.middleCols<3>(fit.view_at(i)) = -part * by_point * cross_matrix(point - pose.tail<3>()) * turn.left_jacobian;
    j.middleCols<3>(fit.view_at(i) + 3) = part * by_point;
  }
  const Eigen::Matrix2d spread = j * fit.covariance.topLeftCorner(n, n) * j.transpose();
  const double mean = 0.5 * spread.trace(), apart = std::hypot(0.5 * (spread(0, 0) - spread(1, 1)), spread(0, 1));
  return std::sqrt(std::max(mean + apart, 0.0));
}

dsp::CameraModel<double> model_of(const CameraFit& fit) {
  const std::vector<double>& k = fit.intrinsics;
  return dsp::CameraModel<double>::make(k[0], k[1], k[2], k[3], std::span(k).subspan(kPinhole)).value();
}

}  // namespace

double projection_uncertainty(const CameraFit& fit, double u, double v, double distance_mm) {
  return deviation_at(fit, model_of(fit), u, v, distance_mm);
}

UncertaintyMap uncertainty_map(const CameraFit& fit, int width, int height, double distance_mm, int columns, int rows) {
  UncertaintyMap map{distance_mm, columns, rows, {}};
  const dsp::CameraModel<double> camera = model_of(fit);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      map.worst_px.push_back(deviation_at(fit, camera, map.u(column, width), map.v(row, height), distance_mm));
  return map;
}

}  // namespace srd::bundle
