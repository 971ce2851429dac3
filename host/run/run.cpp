// SPDX-License-Identifier: Apache-2.0
#include "host/run/run.hpp"

#include <algorithm>
#include <cmath>

#include "host/run/diagnosis.hpp"
#include "host/run/found_index.hpp"
#include "host/run/run_kinds.hpp"
#include "host/run/systematic.hpp"

namespace srd::host {

Outcome<RunResult> run(const RunPlan& plan, const Progress& progress) {
  Outcome<RunResult> result = plan.pattern_run   ? run_pattern(plan, progress)
                              : plan.from_images ? run_images(plan, progress)
                                                 : run_features(plan, progress);
  if (!result) return result;
  const bool nothing =
      std::none_of(result->frames.begin(), result->frames.end(), [](const FrameRecord& frame) { return frame.has_surface(); });
  if (nothing && plan.from_images && !result->frames.empty() && result->diagnosis.empty())
    result->diagnosis = diagnosis(plan, typical_frame(*result));
  if (plan.pattern_run) return result;
  add_systematic(plan, result->frames);
  const std::vector<std::string> warnings = rank_warnings(plan, *result);
  result->warnings.insert(result->warnings.end(), warnings.begin(), warnings.end());
  return result;
}

void number_frames(RunPlan& plan, std::optional<double> rate_hz) {
  plan.times_known = rate_hz.has_value();
  for (std::size_t i = 0; i < plan.cameras.front().frames.size(); ++i) {
    plan.sequences.push_back(i);
    plan.times_ns.push_back(std::llround(static_cast<double>(i) * 1e9 / rate_hz.value_or(1)));
  }
}

std::vector<int> merge_points(Points& all, const Points& own) {
  constexpr double kSame = 1e-6;  // mm
  const std::size_t before = all.size();
  std::vector<int> places;
  for (const dsp::Vec3<double>& point : own) {
    std::size_t place = all.size();
    for (std::size_t i = 0; i < before && place == all.size(); ++i)
      if ((all[i] - point).cwiseAbs().maxCoeff() <= kSame) place = i;
    if (place == all.size()) all.push_back(point);
    places.push_back(static_cast<int>(place));
  }
  return places;
}

}  // namespace srd::host
