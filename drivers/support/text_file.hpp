// SPDX-License-Identifier: Apache-2.0
// Whole small text files, their lines and numbers, with problems that name the file.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd {

// kInput when the file is missing, a folder, unreadable or longer than most_bytes. expected: "a calibration
// file".
[[nodiscard]] Outcome<std::string> read_text_file(const std::filesystem::path& file, const std::string& expected,
                                                  std::size_t most_bytes = std::size_t{1} << 26);
// Replaces the file. kInput when it cannot be written, a full disk included.
[[nodiscard]] Outcome<void> write_text_file(const std::filesystem::path& file, std::string_view text);

// One line of a text, without its end ("\n" or "\r\n").
struct TextLine {
  std::string_view text;
  int number = 0;     // from 1
  bool ended = true;  // false: the last line, without a line end
};
[[nodiscard]] std::vector<TextLine> split_lines(std::string_view text);
// Fields between single commas, each without the blanks around it. "" has one empty field.
[[nodiscard]] std::vector<std::string_view> split_commas(std::string_view line);
// Fields between white space, commas or semicolons.
[[nodiscard]] std::vector<std::string_view> split_blanks(std::string_view line);
[[nodiscard]] std::string_view trimmed(std::string_view text);

// The whole field as a finite number (double) or a whole number in the type's range; nothing otherwise.
template <class T>
[[nodiscard]] std::optional<T> parse_number(std::string_view field) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>)
    if (!std::isfinite(value)) return std::nullopt;
  return value;
}

// Shortest text that reads back as the same number.
[[nodiscard]] std::string number_text(double value);

}  // namespace srd
