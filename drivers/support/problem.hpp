// SPDX-License-Identifier: Apache-2.0
// What a person is told when something they gave cannot be used: what, where, expected, found, what to do.
#pragma once

#include <string>

#include "dsp/core/result.hpp"

namespace srd {

// Exit codes of every program.
enum class Exit : int { kDone = 0, kUsage = 2, kInput = 3, kDevice = 4, kNetwork = 5 };

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
