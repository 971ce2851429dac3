// SPDX-License-Identifier: Apache-2.0
// The host's half of the wire: reads what nodes send, writes acknowledgements. libprotobuf.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/ending.hpp"
#include "proto/messages.hpp"

namespace srd::proto {

// nullopt for whatever is not a whole, valid datagram from a node, under this key (null: on a link without one).
[[nodiscard]] std::optional<NodeMessage> decode_node_datagram(std::span<const std::uint8_t> datagram, const Key* key = nullptr);

// The same of a datagram without its end, as a record keeps it.
[[nodiscard]] std::optional<NodeMessage> decode_node_message(std::span<const std::uint8_t> message);
// What says how to read such a message: a FileDescriptorSet with srd.wire.NodeDatagram.
[[nodiscard]] std::string record_schema();

// The whole datagram; empty when the acknowledgement is not valid.
[[nodiscard]] std::vector<std::uint8_t> encode_datagram(const Acknowledgement& acknowledgement, const Key* key = nullptr);
[[nodiscard]] std::vector<std::uint8_t> encode_datagram(const Welcome& welcome, const Key& of_node);

}  // namespace srd::proto
