// SPDX-License-Identifier: Apache-2.0
// Short names for Eigen's fixed-size types. All live on the stack.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace srd::dsp {

template <class S>
using Vec2 = Eigen::Matrix<S, 2, 1>;
template <class S>
using Vec3 = Eigen::Matrix<S, 3, 1>;
template <class S>
using Mat2 = Eigen::Matrix<S, 2, 2>;
template <class S>
using Mat3 = Eigen::Matrix<S, 3, 3>;
template <class S>
using Mat23 = Eigen::Matrix<S, 2, 3>;

// False: m has no inverse, or is not finite.
template <class S>
[[nodiscard]] bool invert(const Mat2<S>& m, Mat2<S>& inverse) {
  const S per_det = 1 / (m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0));
  inverse << m(1, 1) * per_det, -m(0, 1) * per_det, -m(1, 0) * per_det, m(0, 0) * per_det;
  using std::isfinite;
  return isfinite(per_det);
}

}  // namespace srd::dsp
