// SPDX-License-Identifier: Apache-2.0
// A conversation, without keys and with them: each input is cut into frames and statuses of a few boots in any order, some of
// them twice. The record must stay in order and without doubles, acknowledgements valid, memory bounded.
#include <cstdlib>
#include <map>

#include "host/listen/receiver.hpp"
#include "proto/node_codec.hpp"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

using namespace srd;

const proto::Key& of_nodes() {
  static const proto::Key key(std::array<std::uint8_t, proto::Key::kBytes>{5});
  return key;
}

// The session that the receiver and this boot agree on.
proto::Key session_of(host::Receiver& receiver, const proto::BootId& boot, const Address& from, std::int64_t now) {
  std::array<std::uint8_t, proto::kMaxDatagram> buffer;
  proto::Hello hello{.stamp = {.sensor_time_ns = now}, .challenge = {static_cast<std::uint8_t>(boot.boot)}};
  const auto bytes = proto::encode(boot, 0, hello, buffer);
  receiver.receive(std::span(buffer).first(proto::seal(buffer, *bytes, 0, &of_nodes())), from, now);
  const auto welcomes = receiver.take_welcomes();
  require(welcomes.size() == 1);
  const auto welcome = proto::decode_welcome(welcomes[0].second, of_nodes());
  require(welcome && welcome->of == boot && welcome->from_node == hello.challenge);
  return proto::session_key(of_nodes(), hello.challenge, welcome->from_host, boot);
}

void converse(std::span<const std::uint8_t> bytes, bool keyed) {
  static const Address from = Address::parse("127.0.0.1:9", "fuzzer").value();
  host::Receiver receiver({}, 1, keyed ? [](const proto::NodeId&) { return std::vector{of_nodes()}; } : host::KeysOfNode());
  std::map<proto::BootId, proto::Key> sessions;
  std::map<proto::BootId, std::uint64_t> next;
  std::int64_t now = 0;
  for (std::size_t i = 0; i + 4 <= bytes.size(); i += 4) {
    proto::BootId boot{*proto::NodeId::make((bytes[i] & 1) != 0 ? "a" : "b"), std::uint64_t{bytes[i]} >> 6};
    const std::uint64_t sequence = bytes[i + 1];
    const std::uint64_t oldest = bytes[i + 2] % (sequence + 1);
    std::array<std::uint8_t, proto::kMaxDatagram> buffer;
    Result<std::size_t> encoded = Errc::kTooSmall;
    if ((bytes[i] & 2) != 0) {
      proto::CoefficientFrame frame;
      frame.model.modes = dsp::ModeList::standard(1).value();
      encoded = proto::encode(boot, sequence, frame, buffer);
    } else {
      proto::NodeStatus status;
      status.lost_ranges.push({bytes[i + 3], std::uint64_t{bytes[i + 3]} + bytes[i] % 7 + 1});
      encoded = proto::encode(boot, sequence, status, buffer);
    }
    require(encoded.ok());
    if (keyed && !sessions.contains(boot)) sessions.emplace(boot, session_of(receiver, boot, from, now));
    const proto::Key* key = keyed ? &sessions.at(boot) : nullptr;
    const auto datagram = std::span(buffer).first(proto::seal(buffer, *encoded, oldest, key));
    for (int copies = (bytes[i] & 8) != 0 ? 2 : 1; copies > 0; --copies) receiver.receive(datagram, from, now);
    now += std::int64_t{bytes[i + 3]} * 100'000'000;
    receiver.tick(now);
    if ((bytes[i] & 4) != 0) receiver.give_up();
    while (const auto ready = receiver.ready()) {
      const auto known = next.find(ready->from);
      require(known == next.end() || ready->sequence >= known->second);
      next[ready->from] = ready->sequence + 1;
      receiver.pop_ready();
    }
    for (const auto& [to, answer] : receiver.acknowledgements()) {
      const auto envelope = proto::read_envelope(answer);
      require(envelope.has_value());
      const auto heard = proto::decode_acknowledgement(answer, keyed ? &sessions.at(envelope->of) : nullptr);
      require(heard.has_value());
      const auto delivered = next.find(heard->of);
      require(delivered == next.end() || heard->first_missing >= delivered->second);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  converse({bytes, size}, false);
  converse({bytes, size}, true);
  return 0;
}
