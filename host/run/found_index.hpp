// SPDX-License-Identifier: Apache-2.0
// The index of water that a run estimated, and what its views could not separate, over all frames.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/run/run.hpp"

namespace srd::host {

struct FoundIndex {
  double mean = 0;       // of the frames, weighted by their deviations
  double deviation = 0;  // of the mean: from the frames' own, or from their scatter where that is larger
  double scatter = 0;    // from frame to frame, one standard deviation
  std::size_t frames = 0;
};

// Nothing when the index was given, or no frame has a surface.
[[nodiscard]] std::optional<FoundIndex> found_index(const RunPlan& plan, const RunResult& result);
// Of the results: the one found, else the one given.
[[nodiscard]] double index_of(const RunPlan& plan, const RunResult& result);
// "1.336", or "1.33312 +- 0.00021 (estimated in 12 frames, which scatter by 0.0007)".
[[nodiscard]] std::string index_text(const RunPlan& plan, const RunResult& result);
// "3 of 12 frames: the view cannot separate A10 from A00", one for each different reason.
[[nodiscard]] std::vector<std::string> rank_warnings(const RunPlan& plan, const RunResult& result);

}  // namespace srd::host
