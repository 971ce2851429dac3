// SPDX-License-Identifier: Apache-2.0
#include "drivers/strobe/gpiod_line.hpp"

namespace srd {

std::string LineAddress::text() const { return "line " + line + (chip.empty() ? " of any GPIO chip" : " of " + chip); }

}  // namespace srd
