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

// The option takes one of these words, upper or lower case, for its value. Its help and what it says of another word list them;
// CLI's own transformer lists its map with the values' bytes.
template <class Value>
CLI::Option* takes_one_of(CLI::Option* option, const std::vector<std::pair<std::string, Value>>& choices) {
  std::string names, alternatives;
  for (const auto& [name, value] : choices) {
    names += (names.empty() ? "" : ", ") + name;
    alternatives += (alternatives.empty() ? "" : "|") + name;
  }
  return option
      ->transform(CLI::Validator(
          [choices, names](std::string& text) -> std::string {
            for (const auto& [name, value] : choices)
              if (CLI::detail::to_lower(text) == name) {
                text = std::to_string(static_cast<int>(value));
                return {};
              }
            return "'" + text + "' is none of " + names;
          },
          "", "one_of"))
      ->type_name(alternatives);
}

// The same of whole numbers.
inline CLI::Option* takes_one_of(CLI::Option* option, const std::vector<int>& numbers) {
  std::vector<std::pair<std::string, int>> choices;
  for (const int number : numbers) choices.emplace_back(std::to_string(number), number);
  return takes_one_of(option, choices);
}

}  // namespace srd::host
