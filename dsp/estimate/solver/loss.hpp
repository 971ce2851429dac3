// SPDX-License-Identifier: Apache-2.0
// How much a corner far from the others still counts: rho of optics (15) on the size of a whole corner's residual.
#pragma once

#include <cmath>
#include <cstdint>

namespace srd::dsp {

enum class Loss : std::uint8_t {
  kNone = 0,   // rho(r^2) = r^2
  kHuber = 1,  // grows linearly from 1.5 scales on: a gross corner pulls, but no more than one at that distance
  kTukey = 2,  // level from 5.1 scales on: a gross corner does not pull at all
};

[[nodiscard]] constexpr const char* to_string(Loss loss) {
  switch (loss) {
    case Loss::kNone: return "none";
    case Loss::kHuber: return "huber";
    case Loss::kTukey: return "tukey";
  }
  return "unknown";
}

// A loss with its scale: the standard deviation of one component of We that the frame itself shows.
struct ScaledLoss {
  Loss kind = Loss::kNone;
  double scale = 1;  // > 0

  // Radial in two components, so these are not the tables' 1.345 and 4.685: with Gaussian noise alone, 95 % of the
  // precision of least squares is left.
  static constexpr double kHuberKnee = 1.501, kTukeyEnd = 5.123;  // in scales
  // Of the size of two components, over the standard deviation of one: sqrt(2 ln 2).
  static constexpr double kMedianSize = 1.17741;

  struct Value {
    double rho;         // of r^2, in the unit of r^2
    double weight;      // d rho / d r^2
    double derivative;  // of psi = weight r, by r
  };
  // size2: r^2 = |We|^2.
  [[nodiscard]] Value at(double size2) const {
    switch (kind) {
      case Loss::kNone: break;
      case Loss::kHuber: {
        const double knee = kHuberKnee * scale, size = std::sqrt(size2);
        if (size <= knee) break;
        return {knee * (2 * size - knee), knee / size, 0};
      }
      case Loss::kTukey: {
        const double end2 = kTukeyEnd * kTukeyEnd * scale * scale, ratio = size2 / end2, rest = 1 - ratio;
        if (!(rest > 0)) return {end2 / 3, 0, 0};
        return {end2 / 3 * (1 - rest * rest * rest), rest * rest, rest * (1 - 5 * ratio)};
      }
    }
    return {size2, 1, 1};
  }
};

}  // namespace srd::dsp
