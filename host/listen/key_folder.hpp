// SPDX-License-Identifier: Apache-2.0
// The keys of all nodes that a host listens to: a folder with a file NODE.key each (drivers/support/key_file.hpp). Read again
// while the host runs, so that a node is added, or its key changed, without an interruption. One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"
#include "proto/identity.hpp"
#include "proto/key.hpp"

namespace srd::host {

class KeyFolder {
 public:
  static constexpr std::int64_t kReadAgain = 1'000'000'000;  // ns; no more often than that

  // kUsage: no folder, no key in it, or one that is refused.
  [[nodiscard]] static Outcome<KeyFolder> open(const std::filesystem::path& folder);

  // The newest first; empty for a node without a key. At most every kReadAgain the folder is read again; a file that is
  // refused then leaves the node's keys as they were, and is told of once to notify.
  [[nodiscard]] std::vector<proto::Key> keys_of(const proto::NodeId& node, std::int64_t now,
                                                const std::function<void(const std::string&)>& notify);

  [[nodiscard]] std::size_t size() const { return keys_.size(); }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  [[nodiscard]] std::vector<Problem> read();

  std::filesystem::path folder_;
  std::map<proto::NodeId, std::vector<proto::Key>> keys_;
  std::int64_t read_ns_ = 0;
  std::string told_;  // the last problems
};

}  // namespace srd::host
