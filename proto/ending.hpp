// SPDX-License-Identifier: Apache-2.0
// How a datagram ends (proto/srd.proto): with a key in a tag, which proves that an owner of the key made it, and made it for
// this direction and kind; without one in a check (check.hpp), which finds damage alone. Never both.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "proto/check.hpp"
#include "proto/key.hpp"

namespace srd::proto {

inline constexpr std::size_t kTagBytes = 16;
inline constexpr std::size_t kMostEndBytes = 2 + kTagBytes;

[[nodiscard]] constexpr std::size_t end_bytes(const Key* key) { return key != nullptr ? kMostEndBytes : kCheckBytes; }

// Writes the end behind the first message_bytes; the buffer has end_bytes of room. Gives the whole size.
std::size_t append_end(const Key* key, Direction direction, std::span<std::uint8_t> buffer, std::size_t message_bytes);

// The message without its end; nullopt when it does not hold: under the key, or, without one, as a check. Constant time.
[[nodiscard]] std::optional<std::span<const std::uint8_t>> without_end(const Key* key, Direction direction,
                                                                       std::span<const std::uint8_t> datagram);

// Whether it ends as under some key. Proves nothing.
[[nodiscard]] bool seems_tagged(std::span<const std::uint8_t> datagram);

}  // namespace srd::proto
