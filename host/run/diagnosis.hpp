// SPDX-License-Identifier: Apache-2.0
// Why a run from images measured nothing, as far as its images tell.
#pragma once

#include <cstddef>
#include <string>

#include "host/run/run.hpp"

namespace srd::host {

// The place of the first frame whose status is the commonest. result has frames.
[[nodiscard]] std::size_t typical_frame(const RunResult& result);

// One sentence on that frame and what to look at: what the node says of an image (ImageSketch), samples of fewer bits than were
// taken, no whole board, a board that fits the pose only turned or mirrored, or not at all. Names the file.
[[nodiscard]] std::string diagnosis(const RunPlan& plan, std::size_t frame);

}  // namespace srd::host
