// SPDX-License-Identifier: Apache-2.0
// Values of OpenSRD's settings.xml (OpenCV FileStorage, one <Settings> element) by key. Upper and lower case are the same:
// OpenSRD's versions differ in it. A key may have several names. Problems collect, so a person mends the file in one go.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/support/toml_reader.hpp"

namespace srd::host::opensrd {

// Names of one key in OpenSRD's versions, as they are spelt there.
using KeyNames = std::vector<std::string>;

class XmlValues {
 public:
  // kInput when the file cannot be read; kUsage when it is not such a file.
  [[nodiscard]] static Outcome<XmlValues> load(const std::filesystem::path& file);
  [[nodiscard]] static Outcome<XmlValues> parse(const std::string& text, const std::filesystem::path& file);

  // Each getter marks its names as known. Absent: nullopt. Wrong: nullopt and a problem.
  [[nodiscard]] std::optional<double> number(const KeyNames& key, const NumberRange& range);
  [[nodiscard]] std::optional<int> integer(const KeyNames& key, const NumberRange& range);
  [[nodiscard]] std::optional<bool> flag(const KeyNames& key);
  // Without the double quotes round it; empty text counts as wrong.
  [[nodiscard]] std::optional<std::string> text(const KeyNames& key);
  // "[1.0,2.0]"
  [[nodiscard]] std::optional<std::vector<double>> numbers(const KeyNames& key);

  [[nodiscard]] bool has(const KeyNames& key) const;
  void know(const KeyNames& key);
  // The key is absent and has no default.
  void missing(const KeyNames& key, const std::string& expected);
  void complain(const KeyNames& key, const std::string& expected, const std::string& found);

  // "settings.xml:12", or the file alone when the key is absent.
  [[nodiscard]] std::string where(const KeyNames& key) const;
  // As spelt in the file; else every name: "SurfaceModel or SurfaceModelParameters".
  [[nodiscard]] std::string name(const KeyNames& key) const;
  // Keys of the file that nobody asked for, as spelt there.
  [[nodiscard]] std::vector<std::string> unknown() const;
  [[nodiscard]] Outcome<void> finish() const;

 private:
  struct Entry {
    std::string key;    // as spelt in the file
    std::string value;  // without quotes and surrounding blanks
    int line = 0;       // 0: not known
  };
  [[nodiscard]] const Entry* find(const KeyNames& key) const;
  [[nodiscard]] const Entry* take(const KeyNames& key);

  std::filesystem::path file_;
  std::map<std::string, Entry> entries_;  // by lower-case key
  std::set<std::string> known_;
  std::vector<Problem> problems_;
};

// "[70.0,0.000]" or "70 0": its numbers; nothing when one is not a finite number.
[[nodiscard]] std::optional<std::vector<double>> parse_numbers(std::string_view text);

}  // namespace srd::host::opensrd
