// SPDX-License-Identifier: Apache-2.0
#include "firmware/strobe/lines_low.hpp"

#include <optional>

namespace srd::firmware {

Outcome<void> switch_lines_low(const StrobeSection& section) {
  if (section.mode == StrobeMode::kOff) return {};
  // A line is off from its opening on. One that fails keeps no other from being switched off.
  std::optional<Problem> problem;
  for (const LineAddress& address : {section.line_address(), section.trigger_address()}) {
    if (address.line.empty()) continue;
    if (auto line = open_gpiod_line(address, "srd-node --strobe-low"); !line) problem = line.error();
  }
  if (problem) return *problem;
  return {};
}

}  // namespace srd::firmware
