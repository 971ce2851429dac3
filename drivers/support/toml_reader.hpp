// SPDX-License-Identifier: Apache-2.0
// Strict reading of a TOML file: every value has a type and a range, and a key nobody asked for is an error.
// Problems collect (file, line, key, expected, found); finish() reports them all, so a person mends a file in one go.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd {

struct NumberRange {
  double least = -std::numeric_limits<double>::max();  // NaN and infinity are never accepted
  double most = std::numeric_limits<double>::max();
  std::string unit{};  // for the message: "mm"
};

// "a number from 0 to 5 (mm)", for messages; kind: "a number".
[[nodiscard]] std::string range_text(const NumberRange& range, const std::string& kind);

class TomlFile;

// One table of the file. Each getter marks its key as known. Not present: nullopt. Wrong: nullopt and a problem.
class TomlTable {
 public:
  [[nodiscard]] std::optional<double> number(std::string_view key, const NumberRange& range = {});
  [[nodiscard]] std::optional<std::int64_t> integer(std::string_view key, const NumberRange& range = {});
  [[nodiscard]] std::optional<bool> boolean(std::string_view key);
  [[nodiscard]] std::optional<std::string> text(std::string_view key);
  // Text in quotes, or a whole number >= 0 as its digits: something that has a name or a number.
  [[nodiscard]] std::optional<std::string> name_or_number(std::string_view key);
  // One of a list of words.
  [[nodiscard]] std::optional<std::string> choice(std::string_view key, const std::vector<std::string>& words);
  // length 0: any length.
  [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key, std::size_t length = 0,
                                                           const NumberRange& range = {});
  [[nodiscard]] std::optional<std::vector<std::string>> texts(std::string_view key);
  // A sub-table; an empty one (that says nothing) when absent.
  [[nodiscard]] TomlTable table(std::string_view key);
  // [[key]]: an array of tables; empty when absent.
  [[nodiscard]] std::vector<TomlTable> tables(std::string_view key);
  [[nodiscard]] bool has(std::string_view key) const;

  // "file:line" of a key, or of the table itself for "".
  [[nodiscard]] std::string where(std::string_view key) const;
  // A problem with a value that has the right type: "key 'x' ..." at its line.
  void complain(std::string_view key, const std::string& expected, const std::string& found, const std::string& advice = {});
  // The key is missing and has no default.
  void missing(std::string_view key, const std::string& expected);

 private:
  friend class TomlFile;
  struct Node;
  std::shared_ptr<Node> node_;
};

class TomlFile {
 public:
  // kUsage when the file cannot be read or is not TOML.
  [[nodiscard]] static Outcome<TomlFile> load(const std::filesystem::path& path);
  [[nodiscard]] static Outcome<TomlFile> parse(std::string_view text, const std::string& name);
  [[nodiscard]] TomlTable root() const { return root_; }
  // Unknown keys and everything that getters complained of, in one Problem; done when there is none.
  [[nodiscard]] Outcome<void> finish() const;

 private:
  TomlTable root_;
};

}  // namespace srd
