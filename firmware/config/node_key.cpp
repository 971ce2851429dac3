// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/node_key.hpp"

#include "drivers/support/key_file.hpp"

namespace srd::firmware {

Outcome<std::optional<proto::Key>> read_node_key(const NodeConfig& config) {
  if (config.key.empty()) return std::optional<proto::Key>();
  const auto file = KeyFile::read(config.key);
  if (!file) return file.error();
  if (file->node != config.node_id)
    return Problem{
        Exit::kUsage,           "the key is another node's",
        config.key.string(),    "a key of " + config.node_id,
        "one of " + file->node, "node.id as in the key, or the key of this node (srd keygen " + config.node_id + ")"};
  return std::optional(proto::Key(file->keys.front().bytes()));
}

}  // namespace srd::firmware
