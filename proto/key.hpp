// SPDX-License-Identifier: Apache-2.0
// Secrets of a keyed link: a node's key, which lies in files at both ends, and a session's key, which is made of it and of a
// random number from each end. Keyed BLAKE2b of libsodium. Contents are authenticated, not secret.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "proto/identity.hpp"

namespace srd::proto {

// Wiped from memory when it goes; compared in constant time.
class Key {
 public:
  static constexpr std::size_t kBytes = 32;
  explicit Key(std::span<const std::uint8_t, kBytes> bytes);
  Key(const Key&) = default;
  Key& operator=(const Key&) = default;
  ~Key();
  [[nodiscard]] std::span<const std::uint8_t, kBytes> bytes() const { return bytes_; }
  friend bool operator==(const Key& a, const Key& b);

 private:
  std::array<std::uint8_t, kBytes> bytes_{};
};

// 128 random bits that one end makes for one session: an answer that holds under them was made after them.
using Challenge = std::array<std::uint8_t, 16>;
[[nodiscard]] Challenge random_challenge();

// The key of the session between these two challenges: BLAKE2b, keyed with the node's key, over both challenges, the boot and
// the node's id.
[[nodiscard]] Key session_key(const Key& of_node, const Challenge& from_node, const Challenge& from_host, const BootId& of);

}  // namespace srd::proto
