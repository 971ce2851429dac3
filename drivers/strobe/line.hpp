// SPDX-License-Identifier: Apache-2.0
// One output line of the board: a strobe's driver, a camera's trigger input.
#pragma once

#include <cstdint>

namespace srd {

// Low ("off") when opened and when destroyed, whatever its polarity. One thread at a time.
class OutputLine {
 public:
  OutputLine() = default;
  OutputLine(const OutputLine&) = delete;
  OutputLine& operator=(const OutputLine&) = delete;
  virtual ~OutputLine() = default;
  // A system call of a few microseconds at most; takes nothing from the heap.
  virtual void set(bool on) noexcept = 0;
  // Calls of set that the device refused (unplugged).
  [[nodiscard]] virtual std::uint64_t faults() const noexcept = 0;
};

}  // namespace srd
