// SPDX-License-Identifier: Apache-2.0
// A whole board's corners as observations of the run's points: their order in the image tells which is which, the pose from
// which end they count.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/run/board_corners.hpp"
#include "host/run/run.hpp"

namespace srd::host {

// corners: all of plan.pattern, as find_board_corners gives them. Nothing: one lies outside the field of the calibration.
[[nodiscard]] std::optional<std::vector<dsp::Observation<double>>> placed_board(const RunPlan& plan, const RunCamera& camera,
                                                                                std::span<const BoardCorner> corners);

}  // namespace srd::host
