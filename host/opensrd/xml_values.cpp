// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/xml_values.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "drivers/support/text_file.hpp"

namespace srd::host::opensrd {

namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
const std::string kExpected = "an OpenSRD settings file: XML with <opencv_storage><Settings>";

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// OpenCV keeps quotes or drops them, depending on what else the element holds.
std::string unquoted(std::string_view text) {
  text = trimmed(text);
  while (text.starts_with('"') || text.starts_with('\'')) text = trimmed(text.substr(1));
  while (text.ends_with('"') || text.ends_with('\'')) text = trimmed(text.substr(0, text.size() - 1));
  return std::string(text);
}

// Words that XML separates by blanks arrive as a list; as text they belong together.
std::string value_text(const cv::FileNode& node) {
  if (node.isString()) return unquoted(node.string());
  if (node.isInt()) return std::to_string(static_cast<int>(node));
  if (node.isReal()) return number_text(node.real());
  std::string words;
  if (node.isSeq())
    for (const cv::FileNode& element : node) words += (words.empty() ? "" : " ") + value_text(element);
  return words;
}

// Comments blanked, so that a key in a comment is not mistaken for the element.
std::string without_comments(std::string text) {
  for (std::size_t at = text.find("<!--"); at != std::string::npos; at = text.find("<!--", at)) {
    std::size_t end = text.find("-->", at);
    end = end == std::string::npos ? text.size() : end + 3;
    for (; at < end; ++at)
      if (text[at] != '\n') text[at] = ' ';
  }
  return text;
}

int line_of(const std::string& bare, const std::string& key) {
  const std::string open = "<" + key;
  for (std::size_t at = bare.find(open); at != std::string::npos; at = bare.find(open, at + 1)) {
    const char next = at + open.size() < bare.size() ? bare[at + open.size()] : '\0';
    if (next == '>' || next == ' ' || next == '\t' || next == '\n' || next == '\r' || next == '/')
      return 1 + static_cast<int>(std::count(bare.begin(), bare.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
  }
  return 0;
}

}  // namespace

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('[') != text.ends_with(']')) return std::nullopt;
  if (text.starts_with('[')) text = text.substr(1, text.size() - 2);
  std::vector<double> numbers;
  for (const std::string_view field : split_blanks(text)) {
    const std::optional<double> x = parse_number<double>(field);
    if (!x) return std::nullopt;
    numbers.push_back(*x);
  }
  return numbers;
}

Outcome<XmlValues> XmlValues::load(const std::filesystem::path& file) {
  const Outcome<std::string> text = read_text_file(file, kExpected, kMaxBytes);
  if (!text) return text.error();
  return parse(*text, file);
}

Outcome<XmlValues> XmlValues::parse(const std::string& text, const std::filesystem::path& file) {
  const auto wrong = [&](const std::string& found, const std::string& line = {}) {
    return Problem{Exit::kUsage,
                   "is not an OpenSRD settings file",
                   file.string() + (line.empty() ? "" : ":" + line),
                   kExpected,
                   found,
                   "every value of several words stands in double quotes"};
  };
  if (text.find("<opencv_storage") == std::string::npos) return wrong("no <opencv_storage>");
  XmlValues values;
  values.file_ = file;
  const std::string bare = without_comments(text);
  try {
    const cv::FileStorage storage(text, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_XML);
    if (!storage.isOpened()) return wrong("something OpenCV cannot open");
    const cv::FileNode settings = storage["Settings"];
    if (!settings.isMap()) return wrong("no <Settings> with elements in it");
    for (const std::string& key : settings.keys()) {
      const Entry entry{key, value_text(settings[key]), line_of(bare, key)};
      const auto [earlier, is_new] = values.entries_.emplace(lower(key), entry);
      if (!is_new)
        values.problems_.push_back({Exit::kUsage, "key '" + key + "' is given twice",
                                    file.string() + ":" + std::to_string(entry.line), "every key once",
                                    "the other in line " + std::to_string(earlier->second.line), ""});
    }
  } catch (const cv::Exception& exception) {
    // The parser puts "(line): message" where other exceptions name a function.
    const std::string& said = exception.func;
    const std::size_t close = said.find("): ");
    if (!said.starts_with('(') || close == std::string::npos) return wrong(exception.err);
    return wrong(said.substr(close + 3), said.substr(1, close - 1));
  } catch (const std::exception& exception) {
    return wrong(exception.what());
  }
  return values;
}

const XmlValues::Entry* XmlValues::find(const KeyNames& key) const {
  for (const std::string& name : key)
    if (const auto at = entries_.find(lower(name)); at != entries_.end()) return &at->second;
  return nullptr;
}

const XmlValues::Entry* XmlValues::take(const KeyNames& key) {
  know(key);
  return find(key);
}

void XmlValues::know(const KeyNames& key) {
  for (const std::string& name : key) known_.insert(lower(name));
}

bool XmlValues::has(const KeyNames& key) const { return find(key) != nullptr; }

std::optional<double> XmlValues::number(const KeyNames& key, const NumberRange& range) {
  const Entry* entry = take(key);
  if (entry == nullptr) return std::nullopt;
  const std::optional<double> x = parse_number<double>(entry->value);
  if (x && *x >= range.least && *x <= range.most) return x;
  complain(key, range_text(range, "a number"), entry->value);
  return std::nullopt;
}

std::optional<int> XmlValues::integer(const KeyNames& key, const NumberRange& range) {
  const Entry* entry = take(key);
  if (entry == nullptr) return std::nullopt;
  // 5.0 and 5. are whole numbers too.
  const std::optional<double> x = parse_number<double>(entry->value);
  if (x && *x >= range.least && *x <= range.most && *x == std::floor(*x) && std::abs(*x) < 1e9) return static_cast<int>(*x);
  complain(key, range_text(range, "a whole number"), entry->value);
  return std::nullopt;
}

std::optional<bool> XmlValues::flag(const KeyNames& key) {
  const Entry* entry = take(key);
  if (entry == nullptr) return std::nullopt;
  if (entry->value == "0" || entry->value == "1") return entry->value == "1";
  complain(key, "0 or 1", entry->value);
  return std::nullopt;
}

std::optional<std::string> XmlValues::text(const KeyNames& key) {
  const Entry* entry = take(key);
  if (entry == nullptr) return std::nullopt;
  if (!entry->value.empty()) return entry->value;
  complain(key, "a name in double quotes", "");
  return std::nullopt;
}

std::optional<std::vector<double>> XmlValues::numbers(const KeyNames& key) {
  const Entry* entry = take(key);
  if (entry == nullptr) return std::nullopt;
  std::optional<std::vector<double>> list = parse_numbers(entry->value);
  if (list && !list->empty()) return list;
  complain(key, "a list of numbers as \"[70.0,0.0,0.0]\"", entry->value);
  return std::nullopt;
}

std::string XmlValues::where(const KeyNames& key) const {
  const Entry* entry = find(key);
  return entry == nullptr || entry->line == 0 ? file_.string() : file_.string() + ":" + std::to_string(entry->line);
}

std::string XmlValues::name(const KeyNames& key) const {
  if (const Entry* entry = find(key); entry != nullptr) return entry->key;
  std::string names;
  for (const std::string& name : key) names += (names.empty() ? "" : "' or '") + name;
  return names;
}

void XmlValues::missing(const KeyNames& key, const std::string& expected) {
  know(key);
  problems_.push_back({Exit::kUsage, "key '" + name(key) + "' is missing", file_.string(), expected, "", ""});
}

void XmlValues::complain(const KeyNames& key, const std::string& expected, const std::string& found) {
  problems_.push_back(
      {Exit::kUsage, "key '" + name(key) + "'", where(key), expected, found.empty() ? "nothing" : "'" + found + "'", ""});
}

std::vector<std::string> XmlValues::unknown() const {
  std::vector<std::string> names;
  for (const auto& [key, entry] : entries_)
    if (!known_.contains(key)) names.push_back(entry.key);
  return names;
}

Outcome<void> XmlValues::finish() const {
  if (problems_.empty()) return {};
  if (problems_.size() == 1) return problems_.front();
  Problem all{Exit::kUsage, std::to_string(problems_.size()) + " problems in the file", file_.string()};
  for (const Problem& p : problems_) {
    all.what += "\n  " + p.where + ": " + p.what + "; expected " + p.expected;
    if (!p.found.empty()) all.what += "; found " + p.found;
  }
  return all;
}

}  // namespace srd::host::opensrd
