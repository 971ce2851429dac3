// SPDX-License-Identifier: Apache-2.0
// The node's half of the wire: writes what nodes send, reads acknowledgements. nanopb; no heap, no exceptions.
//
// A datagram is written in two steps, because a frame is encoded once and sent perhaps often: encode gives everything but
// the oldest number held, seal adds that and the end just before sending.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/core/result.hpp"
#include "proto/ending.hpp"
#include "proto/messages.hpp"

namespace srd::proto {

// Room that seal needs behind an encoded message: a field of at most 11 bytes and the end.
inline constexpr std::size_t kSealBytes = 11 + kMostEndBytes;
// No encoded message is longer.
inline constexpr std::size_t kMaxEncoded = kMaxDatagram - kSealBytes;

// No frame of these modes is longer when it is encoded.
[[nodiscard]] std::size_t most_frame_bytes(const dsp::ModeList& modes);

// Bytes written. kInvalidArgument when the message breaks a bound, kTooSmall when it does not fit out (kMaxEncoded always
// suffices). sequence as in NodeHeader.
[[nodiscard]] Result<std::size_t> encode(const BootId& from, std::uint64_t sequence, const CoefficientFrame& frame,
                                         std::span<std::uint8_t> out);
[[nodiscard]] Result<std::size_t> encode(const BootId& from, std::uint64_t sequence, const NodeStatus& status,
                                         std::span<std::uint8_t> out);
[[nodiscard]] Result<std::size_t> encode(const BootId& from, std::uint64_t sequence, const Hello& hello,
                                         std::span<std::uint8_t> out);

// Bytes of the whole datagram. buffer holds the encoded message and kSealBytes of room. Once per encoded copy.
// key: null on a link without one.
[[nodiscard]] std::size_t seal(std::span<std::uint8_t> buffer, std::size_t encoded_bytes, std::uint64_t oldest_held,
                               const Key* key = nullptr);

// nullopt for whatever is not a whole, valid acknowledgement from a host, under this key.
[[nodiscard]] std::optional<Acknowledgement> decode_acknowledgement(std::span<const std::uint8_t> datagram,
                                                                    const Key* key = nullptr);
[[nodiscard]] std::optional<Welcome> decode_welcome(std::span<const std::uint8_t> datagram, const Key& of_node);

}  // namespace srd::proto
