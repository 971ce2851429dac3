// SPDX-License-Identifier: Apache-2.0
// The systematic deviations of a run: what the errors of its cameras' calibrations and poses leave alike in every frame.
#pragma once

#include "host/coefficients/model_file.hpp"
#include "host/run/run.hpp"

namespace srd::host {

// Fills FrameRecord::systematic where a surface was fitted to corners and the errors of every camera's pose are known. With a
// free index it stays empty: the index would take up a part of them.
void add_systematic(const RunPlan& plan, std::vector<FrameRecord>& frames);

// Whose errors those are: of several cameras the oldest files; the calibrations count where each camera's does.
[[nodiscard]] std::optional<ErrorSources> error_sources(const RunPlan& plan);

}  // namespace srd::host
