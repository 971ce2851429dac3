// SPDX-License-Identifier: Apache-2.0
// A user-facing error: what is wrong, where, what was expected and found, what to do about it, and the exit code.
#pragma once

#include <string>

#include "drivers/support/exit_code.hpp"
#include "dsp/core/result.hpp"

namespace srd {

struct Problem {
  Exit exit = Exit::kInput;
  std::string what;     // "unknown key 'refractiv_index'"
  std::string where{};  // "flume.toml:12" or a file's path
  std::string expected{};
  std::string found{};
  std::string advice{};  // what to do

  // One to five lines for stderr: "error: WHERE: WHAT", then "  expected: ..", "  found: ..", "  try: ..".
  [[nodiscard]] std::string text() const;
};

template <class T>
using Outcome = Result<T, Problem>;

}  // namespace srd
