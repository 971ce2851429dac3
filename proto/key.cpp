// SPDX-License-Identifier: Apache-2.0
#include "proto/key.hpp"

#include <sodium.h>

#include <algorithm>

namespace srd::proto {
namespace {

// Chooses the processor's fastest code, once. Without it everything works by the plain one.
void start_library() {
  static const int ready = sodium_init();
  (void)ready;
}

}  // namespace

Key::Key(std::span<const std::uint8_t, kBytes> bytes) {
  start_library();
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
}

Key::~Key() { sodium_memzero(bytes_.data(), bytes_.size()); }

bool operator==(const Key& a, const Key& b) { return sodium_memcmp(a.bytes_.data(), b.bytes_.data(), Key::kBytes) == 0; }

Challenge random_challenge() {
  start_library();
  Challenge challenge;
  randombytes_buf(challenge.data(), challenge.size());
  return challenge;
}

Key session_key(const Key& of_node, const Challenge& from_node, const Challenge& from_host, const BootId& of) {
  std::array<std::uint8_t, 8> boot{};
  for (std::size_t i = 0; i < boot.size(); ++i) boot[i] = static_cast<std::uint8_t>(of.boot >> (8 * i));
  crypto_generichash_state state;
  std::array<std::uint8_t, Key::kBytes> made{};
  crypto_generichash_init(&state, of_node.bytes().data(), Key::kBytes, made.size());
  crypto_generichash_update(&state, from_node.data(), from_node.size());
  crypto_generichash_update(&state, from_host.data(), from_host.size());
  crypto_generichash_update(&state, boot.data(), boot.size());
  // The one part of any length is the last.
  crypto_generichash_update(&state, reinterpret_cast<const std::uint8_t*>(of.node.view().data()), of.node.view().size());
  crypto_generichash_final(&state, made.data(), made.size());
  sodium_memzero(&state, sizeof state);
  const Key key{std::span<const std::uint8_t, Key::kBytes>(made)};
  sodium_memzero(made.data(), made.size());
  return key;
}

}  // namespace srd::proto
