// SPDX-License-Identifier: Apache-2.0
// What a person sees while and after srd reconstruct runs. Progress only on a terminal.
#pragma once

#include <string>
#include <vector>

#include "host/run/run.hpp"

namespace srd::host {

// A line on stderr that counts frames; does nothing when stderr is not a terminal.
[[nodiscard]] Progress terminal_progress();
// Warnings to stderr, the head, the means and where the results are to stdout. kInput when no frame has a surface.
[[nodiscard]] Outcome<void> report(const RunPlan& plan, const RunResult& result, const std::vector<std::string>& head,
                                   const std::vector<std::string>& warnings, const std::filesystem::path& out);

}  // namespace srd::host
