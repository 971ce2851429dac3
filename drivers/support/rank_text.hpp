// SPDX-License-Identifier: Apache-2.0
// What the corners of a view cannot tell apart, in words.
#pragma once

#include <string>

#include "dsp/estimate/solver/rank_report.hpp"

namespace srd {

// "the view cannot separate A10 from A00 and C; A22 has no effect on the corners", one part a dependence. Empty for a
// report without any. modes: of the fit.
[[nodiscard]] std::string rank_text(const dsp::RankReport& report, const dsp::ModeList& modes);

}  // namespace srd
