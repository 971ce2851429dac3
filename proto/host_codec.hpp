// SPDX-License-Identifier: Apache-2.0
// The host's half of the wire: reads what nodes send, writes acknowledgements. libprotobuf.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/messages.hpp"

namespace srd::proto {

// nullopt for whatever is not a whole, valid datagram from a node.
[[nodiscard]] std::optional<NodeMessage> decode_node_datagram(std::span<const std::uint8_t> datagram);

// The whole datagram; empty when the acknowledgement is not valid.
[[nodiscard]] std::vector<std::uint8_t> encode_datagram(const Acknowledgement& acknowledgement);

}  // namespace srd::proto
