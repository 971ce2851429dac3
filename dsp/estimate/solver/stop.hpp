// SPDX-License-Identifier: Apache-2.0
// Why an estimate ended.
#pragma once

#include <cstdint>

namespace srd::dsp {

// delta is the next step, D = diag(scale), g = J'We the gradient over the coefficients that no bound holds, cost =
// |We|^2, promised the fall of the cost that the linear model gives for delta. Numbers are on the wire.
enum class Stop : std::uint8_t {
  kGradient = 0,       // |D g|_inf <= epsg
  kCost = 1,           // promised <= epsf cost + what rounding promises, undamped
  kStep = 2,           // |D^-1 delta|_2 <= epsx, undamped
  kMaxIterations = 3,  // maxits trial points were evaluated
  kDeadline = 4,       // the callback said stop; the best so far is returned
  kNoProgress = 5,     // promised is below the rounding of the cost, or damping is at its limit: as good as the
                       // arithmetic allows
  // Failures: no surface.
  kTooFewCorners = 16,      // fewer than ceil(parameters / 2) corners
  kSingular = 17,           // the corners do not determine the coefficients
  kNonFinite = 18,          // a NaN or infinity came in or up
  kOutOfDomain = 19,        // a ray misses the surface at every start
  kInvalidInput = 20,       // unknown point, missing view, sigma <= 0, too many corners, a start of the wrong length
  kIndexUndetermined = 21,  // the corners do not tell the free index of water from the coefficients
};

[[nodiscard]] constexpr bool failed(Stop stop) { return static_cast<std::uint8_t>(stop) >= 16; }

[[nodiscard]] constexpr const char* to_string(Stop stop) {
  switch (stop) {
    case Stop::kGradient: return "gradient";
    case Stop::kCost: return "cost";
    case Stop::kStep: return "step";
    case Stop::kMaxIterations: return "iterations";
    case Stop::kDeadline: return "deadline";
    case Stop::kNoProgress: return "no progress";
    case Stop::kTooFewCorners: return "too few corners";
    case Stop::kSingular: return "singular";
    case Stop::kNonFinite: return "not finite";
    case Stop::kOutOfDomain: return "out of domain";
    case Stop::kInvalidInput: return "invalid input";
    case Stop::kIndexUndetermined: return "index undetermined";
  }
  return "unknown";
}

}  // namespace srd::dsp
