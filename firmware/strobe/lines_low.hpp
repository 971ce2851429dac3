// SPDX-License-Identifier: Apache-2.0
// Drives the strobe and trigger lines low from another process, after an srd-node that was killed.
#pragma once

#include "drivers/support/problem.hpp"
#include "firmware/strobe/strobe_section.hpp"

namespace srd::firmware {

// Every line of the section off, then released. Nothing happens when the section has none. kDevice for a line that is not
// there, not permitted, or in use by a node that runs.
[[nodiscard]] Outcome<void> switch_lines_low(const StrobeSection& section);

}  // namespace srd::firmware
