// SPDX-License-Identifier: Apache-2.0
// A file with the key of one node, the same at the node and at the host: a line "flume-srd-key-1 NODE 64-HEXADECIMAL-DIGITS".
// The host's may have a second line, the key from before a change. Only its owner may be able to read it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd {

// Bytes that are wiped from memory when they go.
class SecretBytes {
 public:
  static constexpr std::size_t kBytes = 32;
  SecretBytes() = default;
  SecretBytes(const SecretBytes&) = default;
  SecretBytes& operator=(const SecretBytes&) = default;
  ~SecretBytes();
  [[nodiscard]] static SecretBytes random();
  [[nodiscard]] const std::array<std::uint8_t, kBytes>& bytes() const { return bytes_; }
  [[nodiscard]] std::array<std::uint8_t, kBytes>& bytes() { return bytes_; }
  friend bool operator==(const SecretBytes& a, const SecretBytes& b);  // constant time

 private:
  std::array<std::uint8_t, kBytes> bytes_{};
};

struct KeyFile {
  static constexpr std::size_t kMostKeys = 2;
  std::string node;
  std::vector<SecretBytes> keys;  // 1 or 2, the newest first

  // kUsage when the file is missing, can be read by others than its owner, belongs to another user, or is no key file; the
  // advice is the command that mends it.
  [[nodiscard]] static Outcome<KeyFile> read(const std::filesystem::path& file);
  // A new file, or in place of the one that is there: whole or not at all, readable by its owner alone. kInput.
  [[nodiscard]] Outcome<void> write(const std::filesystem::path& file) const;
};

}  // namespace srd
