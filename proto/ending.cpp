// SPDX-License-Identifier: Apache-2.0
#include "proto/ending.hpp"

#include <sodium.h>

#include <array>

#include "proto/envelope.hpp"

namespace srd::proto {
namespace {

constexpr std::uint8_t kTagField = (14 << 3) | 2;  // field 14, bytes

using Tag = std::array<std::uint8_t, kTagBytes>;

Tag tag_of(const Key& key, Direction direction, std::span<const std::uint8_t> message) {
  const auto envelope = read_envelope(message);
  const std::array<std::uint8_t, 2> start{static_cast<std::uint8_t>(direction),
                                          static_cast<std::uint8_t>(envelope ? envelope->content : Content::kNone)};
  Tag tag;
  crypto_generichash_state state;
  crypto_generichash_init(&state, key.bytes().data(), Key::kBytes, tag.size());
  crypto_generichash_update(&state, start.data(), start.size());
  crypto_generichash_update(&state, message.data(), message.size());
  crypto_generichash_final(&state, tag.data(), tag.size());
  sodium_memzero(&state, sizeof state);
  return tag;
}

}  // namespace

std::size_t append_end(const Key* key, Direction direction, std::span<std::uint8_t> buffer, std::size_t message_bytes) {
  if (key == nullptr) return append_check(direction, buffer, message_bytes);
  const Tag tag = tag_of(*key, direction, buffer.first(message_bytes));
  buffer[message_bytes] = kTagField;
  buffer[message_bytes + 1] = static_cast<std::uint8_t>(kTagBytes);
  std::copy(tag.begin(), tag.end(), buffer.begin() + static_cast<std::ptrdiff_t>(message_bytes) + 2);
  return message_bytes + kMostEndBytes;
}

bool seems_tagged(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kMostEndBytes) return false;
  const auto end = datagram.last(kMostEndBytes);
  return end[0] == kTagField && end[1] == kTagBytes;
}

std::optional<std::span<const std::uint8_t>> without_end(const Key* key, Direction direction,
                                                         std::span<const std::uint8_t> datagram) {
  if (key == nullptr) return checked(direction, datagram);
  if (!seems_tagged(datagram)) return std::nullopt;
  const auto message = datagram.first(datagram.size() - kMostEndBytes);
  const Tag wanted = tag_of(*key, direction, message);
  if (sodium_memcmp(wanted.data(), datagram.last(kTagBytes).data(), kTagBytes) != 0) return std::nullopt;
  return message;
}

}  // namespace srd::proto
