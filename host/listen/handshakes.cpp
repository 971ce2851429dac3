// SPDX-License-Identifier: Apache-2.0
#include "host/listen/handshakes.hpp"

#include <algorithm>

namespace srd::host {

using proto::BootId;
using proto::NodeMessage;

// With as many as are kept, the one goes that was silent longest, and of those first one without a session. Should its node
// live, it says hello again.
Handshakes::Boot* Handshakes::boot_of(const BootId& id, const proto::Key& of_node, std::int64_t now) {
  if (const auto found = boots_.find(id); found != boots_.end()) return &found->second;
  if (boots_.size() >= kMost) {
    const auto rank = [](const auto& entry) { return std::pair(entry.second.current.has_value(), entry.second.heard_ns); };
    boots_.erase(
        std::min_element(boots_.begin(), boots_.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); }));
  }
  Boot boot{.of_node = of_node, .waiting = {}, .current = {}, .heard_ns = now};
  return &boots_.emplace(id, std::move(boot)).first->second;
}

std::optional<std::vector<std::uint8_t>> Handshakes::answer(std::span<const std::uint8_t> hello,
                                                            const proto::Envelope& envelope, std::int64_t now) {
  using Bytes = std::vector<std::uint8_t>;
  for (const proto::Key& key : keys_(envelope.of.node)) {
    const auto message = proto::decode_node_datagram(hello, &key);
    if (!message || message->header.from != envelope.of) continue;
    const auto* asked = std::get_if<proto::Hello>(&message->content);
    if (asked == nullptr) return Bytes{};
    const bool known = boots_.contains(envelope.of);
    Boot& boot = *boot_of(envelope.of, key, now);
    const bool again = known && asked->challenge == boot.from_node;
    if (known && !again && asked->stamp.sensor_time_ns <= boot.hello_ns) return Bytes{};  // someone sends an old one
    if (!again) {
      boot.of_node = key;
      boot.hello_ns = asked->stamp.sensor_time_ns;
      boot.from_node = asked->challenge;
      boot.from_host = proto::random_challenge();
      boot.waiting = Session{.key = proto::session_key(key, boot.from_node, boot.from_host, envelope.of)};
      boot.heard_ns = now;
    }
    return proto::encode_datagram(proto::Welcome{.of = envelope.of,
                                                 .session = session_,
                                                 .serial = ++serial_,
                                                 .from_node = boot.from_node,
                                                 .from_host = boot.from_host},
                                  boot.of_node);
  }
  return std::nullopt;
}

std::optional<NodeMessage> Handshakes::open(std::span<const std::uint8_t> datagram, const proto::Envelope& envelope,
                                            std::int64_t now) {
  const auto found = boots_.find(envelope.of);
  if (found == boots_.end()) return std::nullopt;
  Boot& boot = found->second;
  std::optional<NodeMessage> message;
  if (boot.current) message = proto::decode_node_datagram(datagram, &boot.current->key);
  if (!message && boot.waiting) {
    message = proto::decode_node_datagram(datagram, &boot.waiting->key);
    if (message) {
      boot.current = *boot.waiting;
      boot.waiting.reset();
    }
  }
  if (!message || message->header.from != envelope.of || std::holds_alternative<proto::Hello>(message->content))
    return std::nullopt;
  if (const auto* status = std::get_if<proto::NodeStatus>(&message->content)) {
    Session& session = *boot.current;
    if (session.any_status && status->stamp.sensor_time_ns <= session.status_ns) return std::nullopt;
    session.any_status = true;
    session.status_ns = status->stamp.sensor_time_ns;
  }
  boot.heard_ns = now;
  return message;
}

const proto::Key* Handshakes::session_key(const BootId& of) const {
  const auto found = boots_.find(of);
  return found != boots_.end() && found->second.current ? &found->second.current->key : nullptr;
}

}  // namespace srd::host
