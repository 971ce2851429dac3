// SPDX-License-Identifier: Apache-2.0
// The ways of run(): frames whose corners are known already, from feature files; frames as images; and images by the
// pattern metric.
#pragma once

#include "host/run/run.hpp"

namespace srd::host {

[[nodiscard]] Outcome<RunResult> run_features(const RunPlan& plan, const Progress& progress);
[[nodiscard]] Outcome<RunResult> run_images(const RunPlan& plan, const Progress& progress);
// plan.pattern_run. Frames are fitted in blocks of fixed size, each of which starts from the guess.
[[nodiscard]] Outcome<RunResult> run_pattern(const RunPlan& plan, const Progress& progress);

// No estimator can be made for the plan.
[[nodiscard]] Problem unusable_model(Errc code);

}  // namespace srd::host
