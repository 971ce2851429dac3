// SPDX-License-Identifier: Apache-2.0
// The check at a datagram's end (proto/srd.proto): finds truncated, damaged, reflected and foreign datagrams. It is no
// proof of who sent it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace srd::proto {

enum class Direction : std::uint8_t { kFromNode = 'N', kFromHost = 'H' };

inline constexpr std::size_t kCheckBytes = 5;
inline constexpr std::uint8_t kCheckTag = (15 << 3) | 5;  // field 15, fixed32

namespace detail {
// CRC-32C, reflected polynomial 0x82F63B78, one byte at a time.
inline constexpr std::array<std::uint32_t, 256> kCrcTable = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c >> 1) ^ ((c & 1) != 0 ? 0x82F63B78u : 0u);
    table[i] = c;
  }
  return table;
}();
}  // namespace detail

[[nodiscard]] constexpr std::uint32_t crc32c(std::uint32_t crc, std::span<const std::uint8_t> bytes) {
  crc = ~crc;
  for (const std::uint8_t byte : bytes) crc = (crc >> 8) ^ detail::kCrcTable[(crc ^ byte) & 0xFF];
  return ~crc;
}

[[nodiscard]] constexpr std::uint32_t check_of(Direction direction, std::span<const std::uint8_t> message) {
  const std::uint8_t letter = static_cast<std::uint8_t>(direction);
  return crc32c(crc32c(0, std::span(&letter, 1)), message);
}

// Writes the check behind the first message_bytes; the buffer has kCheckBytes of room. Gives the whole size.
constexpr std::size_t append_check(Direction direction, std::span<std::uint8_t> buffer, std::size_t message_bytes) {
  const std::uint32_t check = check_of(direction, buffer.first(message_bytes));
  buffer[message_bytes] = kCheckTag;
  for (std::size_t i = 0; i < 4; ++i) buffer[message_bytes + 1 + i] = static_cast<std::uint8_t>(check >> (8 * i));
  return message_bytes + kCheckBytes;
}

// The message without its check, or nullopt when the check does not hold.
[[nodiscard]] constexpr std::optional<std::span<const std::uint8_t>> checked(Direction direction,
                                                                             std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kCheckBytes) return std::nullopt;
  const auto message = datagram.first(datagram.size() - kCheckBytes);
  if (datagram[message.size()] != kCheckTag) return std::nullopt;
  std::uint32_t stated = 0;
  for (std::size_t i = 0; i < 4; ++i) stated |= std::uint32_t{datagram[message.size() + 1 + i]} << (8 * i);
  if (stated != check_of(direction, message)) return std::nullopt;
  return message;
}

}  // namespace srd::proto
