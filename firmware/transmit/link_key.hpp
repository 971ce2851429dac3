// SPDX-License-Identifier: Apache-2.0
// The node's half of a keyed link's session (proto/srd.proto): says hello until the host has answered, and again when it has
// been silent, for a host that started anew knows of no session. No socket, no clock, no heap. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "proto/node_codec.hpp"

namespace srd::firmware {

class LinkKey {
 public:
  // of_node: none on a link without keys. interval: between two hellos, ns. silence: of the host, before a hello, ns.
  LinkKey(const proto::BootId& from, const std::optional<proto::Key>& of_node, std::int64_t interval, std::int64_t silence)
      : from_(from), of_node_(of_node), interval_(interval), silence_(silence) {}

  // Whether frames and statuses can be sent: there is a session, or no key at all.
  [[nodiscard]] bool open() const { return !of_node_ || session_; }
  [[nodiscard]] bool keyed() const { return of_node_.has_value(); }
  // What they end under; null on a link without keys.
  [[nodiscard]] const proto::Key* key() const { return session_ ? &*session_ : nullptr; }

  // The whole hello that is due, in this buffer of kMaxDatagram; empty: none. heard_ns: when the host was last heard.
  // next, oldest: of the frames, as seal and encode have them.
  [[nodiscard]] std::span<const std::uint8_t> hello(std::int64_t now, std::int64_t heard_ns, std::uint64_t next,
                                                    std::uint64_t oldest, std::span<std::uint8_t> buffer);
  // True when this datagram is the answer to the last hello: from now on its session counts.
  [[nodiscard]] bool take_welcome(std::span<const std::uint8_t> datagram, std::int64_t now);

 private:
  proto::BootId from_;
  std::optional<proto::Key> of_node_, session_;
  std::int64_t interval_, silence_;
  std::optional<proto::Challenge> asked_;  // not answered yet
  std::int64_t asked_ns_ = 0;              // when it was made
  std::int64_t sent_ns_ = 0;
  bool sent_ = false;
  std::int64_t since_ns_ = 0;  // of the session
};

}  // namespace srd::firmware
