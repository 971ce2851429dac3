// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace srd::bundle {

// What a chi-square of n degrees of freedom exceeds with the probability of a normal number beyond z (Wilson and Hilferty,
// PNAS 17 (1931) 684).
[[nodiscard]] inline double chi_square_limit(int n, double z) {
  const double part = 2.0 / (9.0 * n), root = 1 - part + z * std::sqrt(part);
  return n * root * root * root;
}

}  // namespace srd::bundle
