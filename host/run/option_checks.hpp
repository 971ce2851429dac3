// SPDX-License-Identifier: Apache-2.0
// What a command's options may be, beyond what CLI11 checks by itself.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace srd::host {

// CLI's own number checks let NaN through.
[[nodiscard]] inline CLI::Validator within(double least, double most, const std::string& unit) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        double x = 0;
        if (CLI::detail::lexical_cast(text, x) && std::isfinite(x) && x > least && x <= most) return {};
        std::array<char, 96> message;
        std::snprintf(message.data(), message.size(), "%s is not a number above %g and up to %g%s%s", text.c_str(), least, most,
                      unit.empty() ? "" : " ", unit.c_str());
        return message.data();
      },
      "", "within");
}

// A word for a value, upper or lower case. CLI's own transformer lists its map with the values' bytes.
template <class Value>
[[nodiscard]] CLI::Validator one_of(const std::vector<std::pair<std::string, Value>>& choices) {
  return CLI::Validator(
      [choices](std::string& text) -> std::string {
        std::string names;
        for (const auto& [name, value] : choices) {
          if (CLI::detail::to_lower(text) == name) {
            text = std::to_string(static_cast<int>(value));
            return {};
          }
          names += (names.empty() ? "" : ", ") + name;
        }
        return "'" + text + "' is none of " + names;
      },
      "", "one_of");
}

}  // namespace srd::host
