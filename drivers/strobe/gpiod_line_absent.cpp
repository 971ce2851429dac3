// SPDX-License-Identifier: Apache-2.0
#include "drivers/strobe/gpiod_line.hpp"

namespace srd {

std::string gpiod_version() { return {}; }

Outcome<std::unique_ptr<OutputLine>> open_gpiod_line(const LineAddress& address, const std::string&,
                                                     const std::filesystem::path&) {
  return Problem{Exit::kUsage,   "this build of the program has no GPIO lines",
                 address.text(), "a build with libgpiod",
                 "none",         "install libgpiod-dev and build again, or set strobe.mode = \"off\""};
}

}  // namespace srd
