// SPDX-License-Identifier: Apache-2.0
// Where a camera sees a point of the pattern, and how that follows the camera's pose and the water's surface.
// Optics (6)-(8), (26).
#pragma once

#include "dsp/optics/ray_trace.hpp"

namespace srd::dsp {

// A small change of a pose: R <- exp([w]x) R, T <- T + t. Entries: w (rad, about the camera's axes), t (mm, in C).
using PoseChange = Eigen::Matrix<double, 6, 1>;
using PoseMatrix = Eigen::Matrix<double, 6, 6>;  // covariance or information of a PoseChange

[[nodiscard]] Pose<double> changed(const Pose<double>& pose, const PoseChange& change);
// The change that leads from one pose to another.
[[nodiscard]] PoseChange change_between(const Pose<double>& from, const Pose<double>& to);
// d centre / d change, the camera's centre in W, mm. Optics (2).
[[nodiscard]] Eigen::Matrix<double, 3, 6> centre_by_change(const Pose<double>& pose);

// What lies between the camera and the pattern.
struct WaterAbove {
  SurfaceModel<double> model;
  Coefficients<double> surface;  // mm above Z = 0
  Media<double> media;
};

struct SeenPoint {
  Vec2<double> pixel;                   // raw image, px
  Vec2<double> normalised;              // the same undistorted: where the ray leaves, whatever the lens does
  Eigen::Matrix<double, 2, 6> by_pose;  // px by PoseChange
  // px by a coefficient a_j: by_height phi_j + by_slope (phi_j,x , phi_j,y)', at foot. Zero without water.
  Vec2<double> by_height = Vec2<double>::Zero();
  Mat2<double> by_slope = Mat2<double>::Zero();
  Vec2<double> foot = Vec2<double>::Zero();  // X, Y where the ray crosses the surface, mm
};

// water: null where there is none, no plates either. kOutOfDomain: the point is behind the camera, or no ray reaches it.
[[nodiscard]] Result<SeenPoint> see_point(const View<double>& view, const Vec3<double>& point, const WaterAbove* water);

}  // namespace srd::dsp
