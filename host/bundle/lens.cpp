// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/lens.hpp"

#include <array>

namespace srd::bundle {

bool is_coefficient_count(int n) { return n == 4 || n == 5 || n == 8 || n == 12 || n == 14; }

std::string intrinsic_name(int index) {
  static constexpr std::array<const char*, kMaxIntrinsics> kNames{"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3",
                                                                  "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tx", "ty"};
  return kNames[static_cast<std::size_t>(index)];
}

bool project(std::span<const double> intrinsics, const Eigen::Vector3d& point, Eigen::Vector2d& pixel,
             IntrinsicsJacobian* by_intrinsics, Eigen::Matrix<double, 2, 3>* by_point) {
  if (!(point.z() > 0)) return false;
  const Eigen::Vector2d xy = point.head<2>() / point.z();
  Eigen::Matrix2d by_xy;
  pixel = dsp::lens_pixel(intrinsics, xy, by_intrinsics, by_point != nullptr ? &by_xy : nullptr);
  if (by_point != nullptr) {
    Eigen::Matrix<double, 2, 3> perspective;
    perspective << 1, 0, -xy.x(), 0, 1, -xy.y();
    *by_point = by_xy * (perspective / point.z());
  }
  return true;
}

}  // namespace srd::bundle
