// SPDX-License-Identifier: Apache-2.0
// Amplitude spectrum of a series with gaps.
#pragma once

#include <span>
#include <vector>

namespace srd::host {

struct Spectrum {
  std::vector<double> frequency_hz;  // from the first above 0 to half the sample rate
  std::vector<double> amplitude;     // of a sine at that frequency, in the series' unit
  double resolution_hz = 0;          // width of a line at half its height: 2 / duration for a Hann window
  double filled_fraction = 0;        // of the samples, taken from the nearest valid frame
};

// One-sided amplitude of the series without its mean, under a Hann window and corrected for its gain (0.5),
// zero-padded to at least four times its length so that a sine between two lines still shows its amplitude
// (within 1 %). seconds ascend; values NaN: no surface. Even steps of interval_s; each takes the nearest
// finite value in time. Empty when there are fewer than 8 steps, no finite value or more than 2^24 steps (a
// gap of days).
[[nodiscard]] Spectrum amplitude_spectrum(std::span<const double> seconds, std::span<const double> values, double interval_s);

}  // namespace srd::host
