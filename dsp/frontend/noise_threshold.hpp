// SPDX-License-Identifier: Apache-2.0
// The least response that noise does not reach, from the image's own noise: what is left below is not worth looking at, and
// what lies above is told from corners by the fit. Contrast and blur of a board do not matter to it.
#pragma once

#include "dsp/core/image_view.hpp"

namespace srd::dsp {

// A threshold for DetectorOptions, kLeastThreshold to kMostThreshold. White noise of s grey levels has a response (22) of mean -2.7 s
// and standard deviation 3.4 s: 16 s lies 5.5 deviations up, 40 places in 10^9 pixels. s is taken from second differences along
// every eighth row, their median, so edges do not matter; black and white that are cut off do not count. Integer arithmetic.
inline constexpr int kLeastThreshold = 32;  // of a corner at the fit's least contrast, blurred to half its response
inline constexpr int kMostThreshold = 400;
[[nodiscard]] int noise_threshold(const GrayView& image);

}  // namespace srd::dsp
