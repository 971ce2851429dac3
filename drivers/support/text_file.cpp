// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/text_file.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace srd {

namespace {

constexpr std::string_view kBlank = " \t\r\v\f";

}  // namespace

Outcome<std::string> read_text_file(const std::filesystem::path& file, const std::string& expected, std::size_t most_bytes) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status))
    return Problem{Exit::kInput, "no such file", file.string(), expected, "", "check the path"};
  if (std::filesystem::is_directory(status))
    return Problem{Exit::kInput, "is a folder", file.string(), expected, "", "name the file in it"};
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    return Problem{Exit::kInput, "cannot be opened", file.string(), expected, std::strerror(errno), "check the permissions"};
  std::string text;
  std::array<char, 1 << 14> chunk;
  while (stream.read(chunk.data(), chunk.size()) || stream.gcount() > 0) {
    text.append(chunk.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > most_bytes)
      return Problem{
          Exit::kInput, "is too large",  file.string(), expected + " of at most " + std::to_string(most_bytes) + " bytes",
          "",           "check the path"};
  }
  if (stream.bad()) return Problem{Exit::kInput, "cannot be read", file.string(), expected, std::strerror(errno), ""};
  return text;
}

Outcome<void> write_text_file(const std::filesystem::path& file, std::string_view text) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream)
    return Problem{Exit::kInput,
                   "cannot be written",
                   file.string(),
                   "a writable folder with room",
                   errno != 0 ? std::strerror(errno) : "",
                   "check the folder, its permissions and the disk"};
  return {};
}

std::vector<TextLine> split_lines(std::string_view text) {
  std::vector<TextLine> lines;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const bool ended = end != std::string_view::npos;
    std::string_view line = text.substr(0, end);
    text.remove_prefix(ended ? end + 1 : text.size());
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back({line, number, ended});
  }
  return lines;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> split_commas(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::vector<std::string_view> split_blanks(std::string_view line) {
  constexpr std::string_view kBetween = " \t\r\v\f,;";
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t first = line.find_first_not_of(kBetween);
    if (first == std::string_view::npos) return fields;
    line.remove_prefix(first);
    const std::size_t end = line.find_first_of(kBetween);
    fields.push_back(line.substr(0, end));
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end);
  }
}

std::string number_text(double value) {
  std::array<char, 32> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

}  // namespace srd
