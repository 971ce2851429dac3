// SPDX-License-Identifier: Apache-2.0
// How far apart in time two frames may be to show one surface: from the fastest wave that the modes can describe.
#pragma once

#include "dsp/optics/surface_model.hpp"

namespace srd::host {

// rad/s of the shortest wave of the modes over water of this depth: omega^2 = (g k + (sigma / rho) k^3) tanh(k depth), Lamb,
// Hydrodynamics, sections 228 and 267; k from the highest harmonics together. 0 for modes without waves (A00, B, C are half a
// wave across the pattern's length scale, as the swash of a tank is).
[[nodiscard]] double fastest_wave(const dsp::SurfaceModel<double>& model, double depth_mm);

// Limits in phase of the fastest wave. Frames are interpolated in time to one moment: within kPairPhase the error of that
// stays below a hundredth of the wave. A clock's error cannot be interpolated away: one standard deviation of it
// moves a wave's slope by kClockPhase of its amplitude, which is stated; beyond, the board is not used.
inline constexpr double kPairPhase = 0.2;    // rad
inline constexpr double kClockPhase = 0.05;  // rad

struct TimeTolerance {
  double pair_s = 0;   // between mid-exposures
  double clock_s = 0;  // one standard deviation of a board's wall time
};
// At most 50 and 20 ms, for surfaces that hardly move.
[[nodiscard]] TimeTolerance tolerance_of(const dsp::SurfaceModel<double>& model, double depth_mm);

}  // namespace srd::host
