// SPDX-License-Identifier: Apache-2.0
// Who sent a datagram: a node's name, its boot, a frame's number.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string_view>

#include "proto/inplace.hpp"

namespace srd::proto {

inline constexpr std::size_t kMaxDatagram = 1200;  // bytes; fits every path without fragments
inline constexpr std::uint32_t kWireVersion = 1;
// Numbers stay below, so that "one past" and differences cannot overflow.
inline constexpr std::uint64_t kMaxSequence = std::uint64_t{1} << 62;

// 1..31 letters, digits, '-', '_', '.': safe in file names, CSV and on a terminal.
class NodeId {
 public:
  static constexpr std::size_t kMaxLength = 31;
  constexpr NodeId() = default;  // empty: nobody
  [[nodiscard]] static constexpr std::optional<NodeId> make(std::string_view name) {
    if (name.empty()) return std::nullopt;
    for (const char c : name) {
      const bool fine =
          (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
      if (!fine) return std::nullopt;
    }
    const auto text = FixedText<kMaxLength>::make(name);
    if (!text) return std::nullopt;
    NodeId id;
    id.text_ = *text;
    return id;
  }
  [[nodiscard]] constexpr std::string_view view() const { return text_.view(); }
  [[nodiscard]] constexpr const char* c_str() const { return text_.c_str(); }
  friend constexpr bool operator==(const NodeId&, const NodeId&) = default;
  friend constexpr auto operator<=>(const NodeId& a, const NodeId& b) { return a.view() <=> b.view(); }

 private:
  FixedText<kMaxLength> text_;
};

// One start of one node.
struct BootId {
  NodeId node;
  std::uint64_t boot = 0;  // random 64 bits
  friend constexpr bool operator==(const BootId&, const BootId&) = default;
  friend constexpr auto operator<=>(const BootId&, const BootId&) = default;
};

// Frames begin, .., end - 1.
struct SequenceRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
  [[nodiscard]] constexpr std::uint64_t size() const { return end - begin; }
  friend constexpr bool operator==(const SequenceRange&, const SequenceRange&) = default;
};

}  // namespace srd::proto
