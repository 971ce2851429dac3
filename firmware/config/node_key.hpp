// SPDX-License-Identifier: Apache-2.0
// The node's key, from the file that node.key names.
#pragma once

#include <optional>

#include "firmware/config/node_config.hpp"
#include "proto/key.hpp"

namespace srd::firmware {

// None when the configuration names no file. kUsage when the file is refused (drivers/support/key_file.hpp) or is another
// node's.
[[nodiscard]] Outcome<std::optional<proto::Key>> read_node_key(const NodeConfig& config);

}  // namespace srd::firmware
