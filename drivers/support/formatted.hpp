// SPDX-License-Identifier: Apache-2.0
// printf into a string: for the lines that people read.
#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

namespace srd {

// At most 255 characters; what is longer is cut.
template <class... Values>
[[nodiscard]] std::string formatted(const char* pattern, Values... values) {
  std::array<char, 256> text;
  const int size = std::snprintf(text.data(), text.size(), pattern, values...);
  return {text.data(), std::min(static_cast<std::size_t>(std::max(size, 0)), text.size() - 1)};
}

}  // namespace srd
