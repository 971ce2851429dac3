// SPDX-License-Identifier: Apache-2.0
// Datagrams to begin with whose check or tag holds, so that the fuzzer reaches what lies behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/ending.hpp"

namespace srd::proto::testing {

inline std::vector<std::uint8_t> with_check(Direction direction, std::span<const std::uint8_t> message) {
  std::vector<std::uint8_t> datagram(message.begin(), message.end());
  datagram.resize(message.size() + kCheckBytes);
  append_check(direction, datagram, message.size());
  return datagram;
}

inline const Key& fuzz_key() {
  static const Key key(std::array<std::uint8_t, Key::kBytes>{1, 2, 3});
  return key;
}

inline std::vector<std::uint8_t> with_tag(Direction direction, std::span<const std::uint8_t> message) {
  std::vector<std::uint8_t> datagram(message.begin(), message.end());
  datagram.resize(message.size() + kMostEndBytes);
  append_end(&fuzz_key(), direction, datagram, message.size());
  return datagram;
}

// A good message, changed as the fuzzer says: triples of place (two bytes) and new value; the last odd byte cuts the end off.
inline std::vector<std::uint8_t> changed(std::vector<std::uint8_t> message, std::span<const std::uint8_t> changes) {
  for (; changes.size() >= 3 && !message.empty(); changes = changes.subspan(3))
    message[(changes[0] * 256u + changes[1]) % message.size()] = changes[2];
  if (changes.size() == 1) message.resize(message.size() - std::min<std::size_t>(message.size(), changes[0]));
  return message;
}

}  // namespace srd::proto::testing
