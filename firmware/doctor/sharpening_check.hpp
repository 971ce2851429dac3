// SPDX-License-Identifier: Apache-2.0
// How much the camera sharpens, from the board in one of its frames.
#pragma once

#include <string>

#include "dsp/frontend/corner_detector.hpp"
#include "dsp/frontend/grid_labelling.hpp"
#include "firmware/doctor/finding.hpp"

namespace srd::firmware {

// By how much of its height an edge of this blur (px, standard deviation of the lens; the pixel averages over its square)
// overshoots after the unsharp mask, as the corner fit models it (optics page). 0: not at all.
[[nodiscard]] double overshoot(const dsp::Sharpening& sharpening, double blur_px);

// Looks for the board and tells what was measured. Nothing is told when no board is found: that is the pattern's own finding.
// kind: of the camera ("v4l2"), whose control is named.
void check_sharpening(const GrayView& image, const dsp::DetectorOptions& options, dsp::BoardSize board, const std::string& kind,
                      Diagnosis& diagnosis);

}  // namespace srd::firmware
