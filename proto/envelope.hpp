// SPDX-License-Identifier: Apache-2.0
// Who a datagram says it is from or for, and what kind of message it is, read before anything has proved it: a key is chosen
// by that, and the tag covers the kind. Reads the outermost fields alone, and believes nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "proto/identity.hpp"

namespace srd::proto {

// The outermost field that holds a message's content (proto/srd.proto).
enum class Content : std::uint8_t { kNone = 0, kFrame = 9, kStatus = 10, kAcknowledgement = 13, kHello = 16, kWelcome = 17 };

struct Envelope {
  BootId of;
  Content content = Content::kNone;
};

namespace detail {

[[nodiscard]] constexpr std::optional<std::uint64_t> take_varint(std::span<const std::uint8_t>& bytes) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64 && !bytes.empty(); shift += 7) {
    const std::uint8_t byte = bytes.front();
    bytes = bytes.subspan(1);
    value |= std::uint64_t{byte & 0x7Fu} << shift;
    if (byte < 0x80) return value;
  }
  return std::nullopt;
}

[[nodiscard]] constexpr Content content_of(std::uint64_t field) {
  switch (field) {
    case 9:
    case 10:
    case 13:
    case 16:
    case 17: return static_cast<Content>(field);
    default: return Content::kNone;
  }
}

}  // namespace detail

// nullopt when the bytes are no message, when there is no node, or when there are two contents.
[[nodiscard]] constexpr std::optional<Envelope> read_envelope(std::span<const std::uint8_t> bytes) {
  constexpr std::uint64_t kNode = 2, kBoot = 3;
  Envelope out;
  while (!bytes.empty()) {
    const auto tag = detail::take_varint(bytes);
    if (!tag) return std::nullopt;
    const std::uint64_t field = *tag >> 3;
    std::uint64_t size = 0;
    switch (*tag & 7) {
      case 0:
        if (!detail::take_varint(bytes)) return std::nullopt;
        break;
      case 1: size = 8; break;
      case 2: {
        const auto length = detail::take_varint(bytes);
        if (!length) return std::nullopt;
        size = *length;
        break;
      }
      case 5: size = 4; break;
      default: return std::nullopt;
    }
    if (size > bytes.size()) return std::nullopt;
    const auto value = bytes.first(static_cast<std::size_t>(size));
    bytes = bytes.subspan(static_cast<std::size_t>(size));
    if ((*tag & 7) == 1 && field == kBoot) {
      out.of.boot = 0;
      for (std::size_t i = 0; i < 8; ++i) out.of.boot |= std::uint64_t{value[i]} << (8 * i);
    }
    if ((*tag & 7) != 2) continue;
    if (field == kNode) {
      std::array<char, NodeId::kMaxLength> name{};
      if (value.size() > name.size()) return std::nullopt;
      for (std::size_t i = 0; i < value.size(); ++i) name[i] = static_cast<char>(value[i]);
      const auto node = NodeId::make({name.data(), value.size()});
      if (!node) return std::nullopt;
      out.of.node = *node;
    } else if (const Content content = detail::content_of(field); content != Content::kNone) {
      if (out.content != Content::kNone) return std::nullopt;
      out.content = content;
    }
  }
  if (out.of.node.view().empty()) return std::nullopt;
  return out;
}

}  // namespace srd::proto
