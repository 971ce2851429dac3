// The two ways of run(): frames whose corners are known already, from feature files; and frames as images.
#pragma once

#include "host/reconstruct/run.hpp"

namespace srd::host {

[[nodiscard]] Outcome<RunResult> run_features(const RunPlan& plan, const Progress& progress);
[[nodiscard]] Outcome<RunResult> run_images(const RunPlan& plan, const Progress& progress);

// No estimator can be made for the plan.
[[nodiscard]] Problem unusable_model(Errc code);
// As the status column of the CSV has it: "ok", "not_converged" (a surface, the best so far), "too_few_corners", "failed".
[[nodiscard]] const char* status_text(dsp::Stop stop);

}  // namespace srd::host
