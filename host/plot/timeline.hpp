// SPDX-License-Identifier: Apache-2.0
// Where the frames of a run stand on the time axis, and which of them follow each other without a gap.
#pragma once

#include <span>
#include <vector>

#include "host/coefficients/row_reader.hpp"
#include "host/plot/axis.hpp"

namespace srd::host {

struct Timeline {
  std::vector<double> seconds;  // since the run's first frame
  std::vector<bool> follows;    // the frame comes straight after the one before: same boot, no sequence or time left out
  double interval_s = 0;        // median between frames of following sequence; 0 when there are none
};

[[nodiscard]] Timeline make_timeline(const CoefficientRun& run);

// Stretches of frames with a finite value that follow each other: what one line may join.
[[nodiscard]] Stretches unbroken(const Timeline& timeline, std::span<const double> values);

}  // namespace srd::host
