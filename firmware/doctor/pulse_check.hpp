// SPDX-License-Identifier: Apache-2.0
// Whether the strobe's pulses fit into the exposures and fall into them.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/camera/frame_timing.hpp"
#include "firmware/doctor/finding.hpp"
#include "firmware/strobe/strobe.hpp"

namespace srd::firmware {

// Mean grey levels of frames that had a pulse and of those that are dark on purpose; nothing: there were too few.
struct StrobedLevels {
  std::optional<double> lit, dark;
};

// timing: of the camera, its exposure the shortest that a frame reported, where they report one. False: the exposure is too
// short for pulse and jitter, or unknown, and that was told.
bool check_exposure(const StrobeSection& section, const FrameTiming& timing, Diagnosis& diagnosis);

// report: of the strobe after its end.
void check_pulses(const StrobeSection& section, const StrobeReport& report, const StrobedLevels& levels, Diagnosis& diagnosis);

}  // namespace srd::firmware
