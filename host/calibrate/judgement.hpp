// SPDX-License-Identifier: Apache-2.0
// Do the views support the model, and what is to be said of them.
#pragma once

#include "host/calibrate/calibration.hpp"

namespace srd::host {

[[nodiscard]] Coverage coverage_of(const CalibrationResult& result);
// Before the adjustment: enough views, one size, boards large enough. kInput with advice.
[[nodiscard]] Outcome<void> check_views(const bundle::BoardShape& board, const std::vector<SightedBoard>& sighted);
// After it: parameters determined, one zoom, tilt. kInput with advice.
[[nodiscard]] Outcome<void> check_fit(const CalibrationResult& result);
// What is less than good, most serious first.
[[nodiscard]] std::vector<std::string> remarks(const CalibrationResult& result);

}  // namespace srd::host
