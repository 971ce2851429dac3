// SPDX-License-Identifier: Apache-2.0
// Colours that people with any colour vision can tell apart, also in grey print.
#pragma once

#include <string_view>

#include "host/plot/scene.hpp"

namespace srd::host {

// Okabe & Ito, Color Universal Design (2008).
inline constexpr Colour kBlack{0, 0, 0}, kOrange{230, 159, 0}, kSky{86, 180, 233}, kGreen{0, 158, 115}, kBlue{0, 114, 178},
    kVermilion{213, 94, 0}, kPurple{204, 121, 167};

inline constexpr Colour kInk{34, 34, 34}, kFaintInk{90, 90, 90}, kGrid{228, 228, 228}, kWhite{255, 255, 255};

[[nodiscard]] constexpr Colour faded(Colour c, double opacity) { return {c.red, c.green, c.blue, opacity}; }

// What the program estimated: its line, and the band of its deviations.
inline constexpr Stroke kEstimateStroke{kBlue, 1.0};
inline constexpr Colour kBandColour = faded(kSky, 0.45);
// How far calibration and pose may have moved all of it: the lines beside.
inline constexpr Stroke kSystematicStroke{kPurple, 1.1};

// Viridis (Smith & van der Walt, 2015) at 0 to 1, dark to light; beyond the ends: the ends.
[[nodiscard]] Colour viridis(double at);

// The colour of a frame's status; statuses that seldom come share black.
[[nodiscard]] Colour status_colour(std::string_view status);

}  // namespace srd::host
