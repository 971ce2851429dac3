// SPDX-License-Identifier: Apache-2.0
// Numbers of 16 bits, IEEE 754 binary16: 11 bits of precision from 6e-5, steps of 6e-8 below.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace srd::proto {

// Rounded to nearest; up to 65504.
[[nodiscard]] inline std::uint16_t half_of(float number) { return Eigen::half_impl::float_to_half_rtne(number).x; }
[[nodiscard]] inline float float_of(std::uint16_t half) {
  return Eigen::half_impl::half_to_float(Eigen::half_impl::raw_uint16_to_half(half));
}

}  // namespace srd::proto
