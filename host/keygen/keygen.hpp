// SPDX-License-Identifier: Apache-2.0
// Makes the key files of nodes. A key is never overwritten: a change keeps the one from before until it is ended, so that the
// node is heard with either.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd::host {

struct KeygenOptions {
  std::vector<std::string> nodes{};
  std::filesystem::path folder{};  // made when it is not there, for its owner alone
  bool change = false;             // a new key before the one that is there
  bool end_change = false;         // only the newest key stays
};

// A line a file that was written. kUsage: no name of a node, a file that is there already (or not, for a change), a file that
// is refused; kInput: cannot write. Nothing is written when one of the nodes is refused.
[[nodiscard]] Outcome<std::string> keygen(const KeygenOptions& options);

}  // namespace srd::host
