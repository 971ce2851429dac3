// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/toml_reader.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

#include <toml++/toml.h>

namespace srd {

namespace {

std::string shown(const toml::node& node) {
  // toml++ casts a NaN to a whole number on its way to text, which is undefined.
  if (node.is_floating_point() && !std::isfinite(*node.value<double>()))
    return std::isnan(*node.value<double>()) ? "nan" : "inf";
  if (node.is_array())
    for (const toml::node& element : *node.as_array())
      if (element.is_floating_point() && !std::isfinite(*element.value<double>())) return "a list with " + shown(element);
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  return out.str();
}

bool inside(double x, const NumberRange& range) { return std::isfinite(x) && x >= range.least && x <= range.most; }

}  // namespace

std::string range_text(const NumberRange& range, const std::string& kind) {
  const auto number = [](double x) {
    std::ostringstream out;
    out << x;
    return out.str();
  };
  const double largest = std::numeric_limits<double>::max();
  std::string text = kind;
  if (range.least > -largest && range.most < largest)
    text += " from " + number(range.least) + " to " + number(range.most);
  else if (range.least > -largest)
    text += " of at least " + number(range.least);
  else if (range.most < largest)
    text += " of at most " + number(range.most);
  if (!range.unit.empty()) text += " (" + range.unit + ")";
  return text;
}

struct TomlTable::Node {
  struct Document {
    toml::table table;
    std::string name;
    std::vector<std::string> problems;
  };
  std::shared_ptr<Document> document;
  const toml::table* table = nullptr;  // null: absent in the file
  std::string path;                    // "camera.", for messages
  std::set<std::string, std::less<>> known;
  std::vector<std::shared_ptr<Node>> children;

  [[nodiscard]] std::string line(const toml::node* at) const {
    std::string text = document->name;
    if (at != nullptr && at->source().begin.line > 0) text += ":" + std::to_string(at->source().begin.line);
    return text;
  }
  void complain(const toml::node* at, const std::string& what, const std::string& expected, const std::string& found,
                const std::string& advice) const {
    std::string text = line(at) + ": " + what;
    if (!expected.empty()) text += "; expected " + expected;
    if (!found.empty()) text += "; found " + found;
    if (!advice.empty()) text += "; " + advice;
    document->problems.push_back(text);
  }
  const toml::node* take(std::string_view key) {
    known.emplace(key);
    return table == nullptr ? nullptr : table->get(key);
  }
  std::shared_ptr<Node> child(const toml::table* sub, std::string sub_path) {
    auto node = std::make_shared<Node>();
    node->document = document;
    node->table = sub;
    node->path = std::move(sub_path);
    children.push_back(node);
    return node;
  }
  void unknown_keys() const {
    if (table != nullptr)
      for (const auto& [key, value] : *table)
        if (!known.contains(key.str())) {
          std::string names;
          for (const auto& name : known) names += (names.empty() ? "" : ", ") + name;
          complain(&value, "unknown key '" + path + std::string(key.str()) + "'", "one of: " + names, "", "");
        }
    for (const auto& c : children) c->unknown_keys();
  }
};

std::optional<double> TomlTable::number(std::string_view key, const NumberRange& range) {
  const toml::node* value = node_->take(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_number()) {
    const double x = *value->value<double>();
    if (inside(x, range)) return x;
  }
  node_->complain(value, "key '" + node_->path + std::string(key) + "'", range_text(range, "a number"), shown(*value), "");
  return std::nullopt;
}

std::optional<std::int64_t> TomlTable::integer(std::string_view key, const NumberRange& range) {
  const toml::node* value = node_->take(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_integer()) {
    const std::int64_t x = *value->value<std::int64_t>();
    if (inside(static_cast<double>(x), range)) return x;
  }
  node_->complain(value, "key '" + node_->path + std::string(key) + "'", range_text(range, "a whole number"), shown(*value),
                  "");
  return std::nullopt;
}

std::optional<bool> TomlTable::boolean(std::string_view key) {
  const toml::node* value = node_->take(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_boolean()) return value->value<bool>();
  node_->complain(value, "key '" + node_->path + std::string(key) + "'", "true or false", shown(*value), "");
  return std::nullopt;
}

std::optional<std::string> TomlTable::text(std::string_view key) {
  const toml::node* value = node_->take(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_string()) return value->value<std::string>();
  node_->complain(value, "key '" + node_->path + std::string(key) + "'", "text in quotes", shown(*value), "");
  return std::nullopt;
}

std::optional<std::string> TomlTable::name_or_number(std::string_view key) {
  const toml::node* value = node_->take(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_string() && !value->value<std::string>()->empty()) return value->value<std::string>();
  if (value->is_integer() && *value->value<std::int64_t>() >= 0) return std::to_string(*value->value<std::int64_t>());
  node_->complain(value, "key '" + node_->path + std::string(key) + "'", "a name in quotes or a whole number", shown(*value),
                  "");
  return std::nullopt;
}

std::optional<std::string> TomlTable::choice(std::string_view key, const std::vector<std::string>& words) {
  std::optional<std::string> word = text(key);
  if (!word) return std::nullopt;
  std::string list;
  for (const std::string& w : words) {
    if (w == *word) return word;
    list += (list.empty() ? "\"" : ", \"") + w + "\"";
  }
  complain(key, "one of " + list, "\"" + *word + "\"");
  return std::nullopt;
}

std::optional<std::vector<double>> TomlTable::numbers(std::string_view key, std::size_t length, const NumberRange& range) {
  const toml::node* value = node_->take(key);
  if (value == nullptr) return std::nullopt;
  std::vector<double> out;
  bool good = value->is_array();
  if (good)
    for (const toml::node& element : *value->as_array()) {
      if (!element.is_number() || !inside(*element.value<double>(), range)) {
        good = false;
        break;
      }
      out.push_back(*element.value<double>());
    }
  if (good && (length == 0 || out.size() == length)) return out;
  const std::string count = length == 0 ? "a list, each " : "a list of " + std::to_string(length) + ", each ";
  node_->complain(value, "key '" + node_->path + std::string(key) + "'", count + range_text(range, "a number"), shown(*value),
                  "");
  return std::nullopt;
}

std::optional<std::vector<std::string>> TomlTable::texts(std::string_view key) {
  const toml::node* value = node_->take(key);
  if (value == nullptr) return std::nullopt;
  std::vector<std::string> out;
  if (value->is_array())
    for (const toml::node& element : *value->as_array())
      if (element.is_string()) out.push_back(*element.value<std::string>());
  if (value->is_array() && out.size() == value->as_array()->size()) return out;
  node_->complain(value, "key '" + node_->path + std::string(key) + "'", "a list of texts in quotes", shown(*value), "");
  return std::nullopt;
}

TomlTable TomlTable::table(std::string_view key) {
  const toml::node* value = node_->take(key);
  const std::string path = node_->path + std::string(key);
  if (value != nullptr && !value->is_table())
    node_->complain(value, "key '" + path + "'", "a table [" + path + "]", shown(*value), "");
  TomlTable out;
  out.node_ = node_->child(value == nullptr ? nullptr : value->as_table(), path + ".");
  return out;
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) {
  const toml::node* value = node_->take(key);
  std::vector<TomlTable> out;
  if (value == nullptr) return out;
  const std::string path = node_->path + std::string(key);
  if (!value->is_array_of_tables()) {
    node_->complain(value, "key '" + path + "'", "tables headed [[" + path + "]]", shown(*value), "");
    return out;
  }
  for (const toml::node& element : *value->as_array()) {
    TomlTable sub;
    sub.node_ = node_->child(element.as_table(), path + "[" + std::to_string(out.size()) + "].");
    out.push_back(sub);
  }
  return out;
}

bool TomlTable::has(std::string_view key) const { return node_->table != nullptr && node_->table->contains(key); }

std::string TomlTable::where(std::string_view key) const {
  if (node_->table == nullptr) return node_->document->name;
  return node_->line(key.empty() ? node_->table : node_->table->get(key));
}

void TomlTable::complain(std::string_view key, const std::string& expected, const std::string& found,
                         const std::string& advice) {
  const toml::node* at = node_->table == nullptr ? nullptr : node_->table->get(key);
  node_->complain(at == nullptr ? node_->table : at, "key '" + node_->path + std::string(key) + "'", expected, found, advice);
}

void TomlTable::missing(std::string_view key, const std::string& expected) {
  node_->known.emplace(key);
  node_->complain(node_->table, "key '" + node_->path + std::string(key) + "' is missing", expected, "", "");
}

Outcome<TomlFile> TomlFile::load(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code error;
  if (!stream || std::filesystem::is_directory(path, error))
    return Problem{Exit::kUsage, "cannot be read", path.string(), "a TOML file", "", "check the path"};
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return parse(text, path.string());
}

Outcome<TomlFile> TomlFile::parse(std::string_view text, const std::string& name) {
  // The library in Debian is the one with exceptions.
  toml::table parsed;
  try {
    parsed = toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    return Problem{
        Exit::kUsage, std::string(error.description()), name + ":" + std::to_string(error.source().begin.line), "TOML", "", ""};
  }
  TomlFile file;
  file.root_.node_ = std::make_shared<TomlTable::Node>();
  file.root_.node_->document =
      std::make_shared<TomlTable::Node::Document>(TomlTable::Node::Document{std::move(parsed), name, {}});
  file.root_.node_->table = &file.root_.node_->document->table;
  return file;
}

Outcome<void> TomlFile::finish() const {
  root_.node_->unknown_keys();
  const auto& problems = root_.node_->document->problems;
  if (problems.empty()) return {};
  Problem problem;
  problem.exit = Exit::kUsage;
  problem.where = root_.node_->document->name;
  problem.what = problems.size() == 1 ? "1 problem in the file" : std::to_string(problems.size()) + " problems in the file";
  for (const std::string& p : problems) problem.what += "\n  " + p;
  return problem;
}

}  // namespace srd
