// SPDX-License-Identifier: Apache-2.0
// An output line of a GPIO chip, through libgpiod (1.6 or 2.x, whichever the build found; or none).
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "drivers/strobe/line.hpp"
#include "drivers/support/problem.hpp"

namespace srd {

struct LineAddress {
  std::string chip;  // path, name or label: "/dev/gpiochip0", "gpiochip0", "pinctrl-bcm2835"; empty: any, by the line's name
  std::string line;  // number on the chip, or name: "17", "GPIO17"
  bool active_low = false;
  // "line 17 of /dev/gpiochip0"
  [[nodiscard]] std::string text() const;
};

// Of the library built in: "libgpiod 1.6.3"; empty: this build has none, and open_gpiod_line refuses.
[[nodiscard]] std::string gpiod_version();

// The line as an output, off. consumer: what others see as its owner. kDevice when there is no such chip or line (both
// are listed), when it is in use (by whom is said) or not permitted (which group may); kUsage when the build has no libgpiod.
// devices: where chips are looked for; another folder in tests.
[[nodiscard]] Outcome<std::unique_ptr<OutputLine>> open_gpiod_line(const LineAddress& address, const std::string& consumer,
                                                                   const std::filesystem::path& devices = "/dev");

}  // namespace srd
