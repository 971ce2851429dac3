// SPDX-License-Identifier: Apache-2.0
// A conversation: each input is cut into frames and statuses of a few boots in any order. The record must stay in order
// and without doubles, acknowledgements valid, memory bounded.
#include <cstdlib>
#include <map>

#include "host/listen/receiver.hpp"
#include "proto/node_codec.hpp"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace srd;
  static const Address from = Address::parse("127.0.0.1:9", "fuzzer").value();
  host::Receiver receiver({}, 1);
  std::map<proto::BootId, std::uint64_t> next;
  std::int64_t now = 0;
  for (std::size_t i = 0; i + 4 <= size; i += 4) {
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
    receiver.receive(std::span(buffer).first(proto::seal(buffer, *encoded, oldest)), from, now);
    now += std::int64_t{bytes[i + 3]} * 100'000'000;
    receiver.tick(now);
    if ((bytes[i] & 4) != 0) receiver.give_up();
    while (const auto ready = receiver.ready()) {
      const auto known = next.find(ready->from);
      require(known == next.end() || ready->sequence >= known->second);
      next[ready->from] = ready->sequence + 1;
      receiver.pop_ready();
    }
    for (const auto& [to, datagram] : receiver.acknowledgements()) {
      const auto heard = proto::decode_acknowledgement(datagram);
      require(heard.has_value());
      const auto delivered = next.find(heard->of);
      require(delivered == next.end() || heard->first_missing >= delivered->second);
    }
  }
  return 0;
}
