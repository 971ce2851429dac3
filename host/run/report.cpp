// SPDX-License-Identifier: Apache-2.0
#include "host/run/report.hpp"

#include <unistd.h>

#include <cstdio>
#include <map>

#include "host/run/found_index.hpp"
#include "host/run/series.hpp"

namespace srd::host {

Progress terminal_progress() {
  if (isatty(STDERR_FILENO) == 0) return {};
  return [](std::size_t done, std::size_t total) {
    std::fprintf(stderr, "\rframe %zu of %zu%s", done, total, done == total ? "\n" : "");
    std::fflush(stderr);
  };
}

Outcome<void> report(const RunPlan& plan, const RunResult& result, const std::vector<std::string>& head,
                     const std::vector<std::string>& warnings, const std::filesystem::path& out) {
  for (const std::string& warning : warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  for (const std::string& warning : result.warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  const RunMeans m = means(plan, result);
  if (m.surfaces == 0) {
    std::map<std::string, int> reasons;
    for (const FrameRecord& frame : result.frames) ++reasons[to_string(frame.status)];
    std::string found;
    for (const auto& [reason, count] : reasons) found += (found.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
    Problem problem{Exit::kInput, "no frame gave a surface", out.string(), "at least one surface", found, ""};
    problem.advice = (result.diagnosis.empty() ? "" : result.diagnosis + "; ") + "summary.txt says why, frame by frame";
    return problem;
  }
  for (const std::string& line : head) std::printf("%s\n", line.c_str());
  std::printf("refractive index %s\n", index_text(plan, result).c_str());
  std::printf("%zu of %zu frames with a surface, mean %s error %.5f %s, mean height over the %s %.4f mm, %.2f ms a frame\n",
              m.surfaces, result.frames.size(), metric_name(plan), m.error, metric_unit(plan),
              plan.pattern_run ? "region" : "pattern", m.height_mm, 1000 * m.seconds_a_frame);
  std::printf("results in %s\n", out.string().c_str());
  return {};
}

}  // namespace srd::host
