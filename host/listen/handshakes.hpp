// SPDX-License-Identifier: Apache-2.0
// The host's half of the sessions of keyed links (proto/srd.proto): answers hellos, and says which key a datagram has to hold
// under. Nothing is kept of a datagram that no key made; so many boots are, whatever comes. No socket, no clock. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "proto/envelope.hpp"
#include "proto/host_codec.hpp"

namespace srd::host {

// The keys that a node may have, the newest first; none: the node is not known.
using KeysOfNode = std::function<std::vector<proto::Key>(const proto::NodeId&)>;

class Handshakes {
 public:
  static constexpr std::size_t kMost = 512;  // boots

  // session: as in acknowledgements.
  Handshakes(KeysOfNode keys, std::uint64_t session) : keys_(std::move(keys)), session_(session) {}

  // The welcome to send back for a hello: nullopt when none of the node's keys made it; empty when it is older than the last.
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> answer(std::span<const std::uint8_t> hello,
                                                                const proto::Envelope& envelope, std::int64_t now);
  // A frame or status that holds under the session of its boot, or under one that waited for its first datagram; a status
  // only when it is younger than the last one of its session.
  [[nodiscard]] std::optional<proto::NodeMessage> open(std::span<const std::uint8_t> datagram, const proto::Envelope& envelope,
                                                       std::int64_t now);
  // Of the session of this boot; null when there is none.
  [[nodiscard]] const proto::Key* session_key(const proto::BootId& of) const;

  [[nodiscard]] bool knows(const proto::NodeId& node) const { return !keys_(node).empty(); }
  [[nodiscard]] std::size_t size() const { return boots_.size(); }

 private:
  struct Session {
    proto::Key key;
    bool any_status = false;
    std::int64_t status_ns = 0;  // by the node's clock: of the last status
  };
  struct Boot {
    proto::Key of_node;         // that made the last hello
    std::int64_t hello_ns = 0;  // by the node's clock: of that hello
    proto::Challenge from_node{}, from_host{};
    std::optional<Session> waiting, current;
    std::int64_t heard_ns = 0;
  };
  Boot* boot_of(const proto::BootId& id, const proto::Key& of_node, std::int64_t now);

  KeysOfNode keys_;
  std::uint64_t session_;
  std::uint64_t serial_ = 0;
  std::map<proto::BootId, Boot> boots_;
};

}  // namespace srd::host
