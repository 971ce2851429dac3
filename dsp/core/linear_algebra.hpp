// Short names for Eigen's fixed-size types. All live on the stack.
#pragma once

#include <Eigen/Core>

namespace srd::dsp {

template <class S> using Vec2 = Eigen::Matrix<S, 2, 1>;
template <class S> using Vec3 = Eigen::Matrix<S, 3, 1>;
template <class S> using Mat2 = Eigen::Matrix<S, 2, 2>;
template <class S> using Mat3 = Eigen::Matrix<S, 3, 3>;
template <class S> using Mat23 = Eigen::Matrix<S, 2, 3>;

}  // namespace srd::dsp
