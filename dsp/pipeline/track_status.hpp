// SPDX-License-Identifier: Apache-2.0
// Why a frame has a surface, or none.
#pragma once

#include <cstdint>

namespace srd::dsp {

enum class TrackStatus : std::uint8_t {
  kOk,
  kNoPattern,      // no grid of corners that could be ours
  kTooFewCorners,  // or too close together: the surface is less sure than max_deviation_mm
  kAmbiguous,      // two placements of the pattern fit alike; no surface is given
  kPoorFit,        // rms above max_rms_px: a wrong identity, or a surface beyond the model
  kInconsistent,   // its corners contradict each other far more than they do as a rule: see inconsistent_factor
  kInterlaced,     // even and odd rows of the image are of two moments: no surface is of one
  kSolverFailed,   // see estimate.stop
  kBadImage,       // an image of another size than the first
};

}  // namespace srd::dsp
