// SPDX-License-Identifier: Apache-2.0
// A calibrated camera at its place in the world: rays of pixels and projections of points. Optics (1), (2), (4).
#pragma once

#include "dsp/optics/camera_model.hpp"

namespace srd::dsp {

// x_C = R X_W + T, mm. Optics (1).
template <class S>
struct Pose {
  Mat3<S> rotation = Mat3<S>::Identity();
  Vec3<S> translation = Vec3<S>::Zero();

  // Camera centre in W. Optics (2).
  [[nodiscard]] Vec3<S> centre() const { return -(rotation.transpose() * translation); }
  template <class T>
  [[nodiscard]] Pose<T> cast() const {
    return {rotation.template cast<T>(), translation.template cast<T>()};
  }
};

// Half line from origin (mm, W) along the unit vector direction.
template <class S>
struct Ray {
  Vec3<S> origin;
  Vec3<S> direction;
};

template <class S>
struct View {
  CameraModel<S> camera;
  Pose<S> pose;

  // Ray of normalised undistorted coordinates; jacobian = d direction / d (x, y). Optics (4).
  [[nodiscard]] Ray<S> ray(const Vec2<S>& xy, Eigen::Matrix<S, 3, 2>* jacobian = nullptr) const;

  // Normalised coordinates of a point seen directly, without water. kOutOfDomain behind the camera.
  [[nodiscard]] Result<Vec2<S>> normalised(const Vec3<S>& point) const;

  template <class T>
  [[nodiscard]] View<T> cast() const {
    return {camera.template cast<T>(), pose.template cast<T>()};
  }
};

template <class S>
Ray<S> View<S>::ray(const Vec2<S>& xy, Eigen::Matrix<S, 3, 2>* jacobian) const {
  const Vec3<S> in_camera(xy.x(), xy.y(), 1);
  const S length = in_camera.norm();
  const Vec3<S> direction = pose.rotation.transpose() * (in_camera / length);
  if (jacobian != nullptr) {
    const Eigen::Matrix<S, 3, 2> raw = pose.rotation.template topRows<2>().transpose() / length;
    *jacobian = raw - direction * (direction.transpose() * raw);
  }
  return {pose.centre(), direction};
}

template <class S>
Result<Vec2<S>> View<S>::normalised(const Vec3<S>& point) const {
  const Vec3<S> c = pose.rotation * point + pose.translation;
  if (!(c.z() > 0)) return Errc::kOutOfDomain;
  return Vec2<S>(c.x() / c.z(), c.y() / c.z());
}

extern template struct View<float>;
extern template struct View<double>;

}  // namespace srd::dsp
