// SPDX-License-Identifier: Apache-2.0
// What differs between libgpiod 1 and 2, and nothing else: gpiod_chip_v1.cpp or gpiod_chip_v2.cpp is built.
#pragma once

#include <memory>
#include <string>

#include "drivers/strobe/line.hpp"

namespace srd {

struct GpioLineInfo {
  unsigned offset = 0;
  std::string name;      // empty: none
  bool used = false;     // by a program or the kernel
  std::string consumer;  // who uses it
};

class GpioChip {
 public:
  virtual ~GpioChip() = default;
  // Null, and errno, when path is no GPIO chip or cannot be opened.
  [[nodiscard]] static std::unique_ptr<GpioChip> open(const std::string& path);
  [[nodiscard]] virtual std::string name() const = 0;   // "gpiochip0"
  [[nodiscard]] virtual std::string label() const = 0;  // "pinctrl-bcm2711"
  [[nodiscard]] virtual unsigned line_count() const = 0;
  // False, and errno.
  [[nodiscard]] virtual bool line(unsigned offset, GpioLineInfo& info) const = 0;
  // As an output, off. Null, and errno.
  [[nodiscard]] virtual std::unique_ptr<OutputLine> request(unsigned offset, bool active_low,
                                                            const std::string& consumer) const = 0;
  [[nodiscard]] static std::string library_version();
};

}  // namespace srd
