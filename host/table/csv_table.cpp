#include "host/table/csv_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

namespace srd::host {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '\r')) s.remove_suffix(1);
  return s;
}

template <class T>
bool parse_whole(std::string_view cell, T& value) {
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} && end == cell.data() + cell.size();
}

}  // namespace

Outcome<CsvTable> CsvTable::read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text;
  if (in) text.assign(std::istreambuf_iterator<char>(in), {});
  if (!in || in.bad())
    return Problem{.what = "cannot read the file", .where = file.string(), .expected = "a CSV file with a header line"};
  return parse(std::move(text), file.string());
}

Outcome<CsvTable> CsvTable::parse(std::string text, std::string name) {
  CsvTable table;
  table.name_ = std::move(name);
  table.text_ = std::move(text);
  const std::string& all = table.text_;
  table.file_bytes_ = all.size();
  std::size_t at = all.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  std::size_t line_number = 0;
  while (true) {
    const std::size_t end = all.find('\n', at);
    if (end == std::string::npos) break;
    ++line_number;
    const std::string_view line = std::string_view(all).substr(at, end - at);
    const std::string here = table.name_ + ":" + std::to_string(line_number);
    if (line.find('"') != std::string_view::npos)
      return Problem{.what = "quotes are not understood", .where = here, .expected = "cells apart by commas, without quotes"};
    if (line_number == 1) {
      std::set<std::string> seen;
      for (std::size_t from = 0;;) {
        const std::size_t comma = std::min(line.find(',', from), line.size());
        const std::string column(trimmed(line.substr(from, comma - from)));
        if (column.empty())
          return Problem{.what = "a column without a name", .where = here, .expected = "a header line of column names"};
        if (!seen.insert(column).second)
          return Problem{.what = "column '" + column + "' is there twice", .where = here, .expected = "different names"};
        table.columns_.push_back(column);
        if (comma == line.size()) break;
        from = comma + 1;
      }
    } else if (!trimmed(line).empty()) {
      const auto cells = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
      if (cells != table.columns_.size())
        return Problem{.what = "a row of another length than the header",
                       .where = here,
                       .expected = std::to_string(table.columns_.size()) + " cells",
                       .found = std::to_string(cells)};
      table.cells_.push_back(at);
      for (std::size_t i = at; i < end; ++i)
        if (all[i] == ',') table.cells_.push_back(i + 1);
      table.lines_.push_back(line_number);
    }
    at = end + 1;
    table.whole_bytes_ = at;
  }
  if (table.columns_.empty())
    return Problem{.what = "no header line", .where = table.name_, .expected = "column names, apart by commas"};
  return table;
}

int CsvTable::index_of(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  return found == columns_.end() ? -1 : static_cast<int>(found - columns_.begin());
}

std::string_view CsvTable::cell(std::size_t row, int column) const {
  const std::size_t from = cells_[row * columns_.size() + static_cast<std::size_t>(column)];
  const std::size_t to = text_.find_first_of(",\n", from);
  return trimmed(std::string_view(text_).substr(from, to - from));
}

std::string CsvTable::where(std::size_t row) const { return name_ + ":" + std::to_string(lines_[row]); }

Outcome<int> CsvTable::require(std::string_view column) const {
  const int index = index_of(column);
  if (index >= 0) return index;
  std::string found;
  for (const std::string& c : columns_) found += (found.empty() ? "" : ",") + c;
  return Problem{.what = "no column '" + std::string(column) + "'", .where = name_ + ":1", .found = found};
}

Problem CsvTable::bad_cell(std::size_t row, std::string_view column, std::string expected) const {
  return Problem{.what = "bad value in column '" + std::string(column) + "'",
                 .where = where(row),
                 .expected = std::move(expected),
                 .found = "'" + std::string(cell(row, index_of(column))) + "'"};
}

Outcome<std::vector<double>> CsvTable::numbers(std::string_view column) const {
  const Outcome<int> index = require(column);
  if (!index) return index.error();
  std::vector<double> values(rows(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t row = 0; row < rows(); ++row) {
    const std::string_view text = cell(row, *index);
    if (text.empty()) continue;
    if (!parse_whole(text, values[row]) || !std::isfinite(values[row]))
      return bad_cell(row, column, "a finite number or nothing");
  }
  return values;
}

template <class T>
Outcome<std::vector<T>> CsvTable::exact(std::string_view column, const char* expected) const {
  const Outcome<int> index = require(column);
  if (!index) return index.error();
  std::vector<T> values(rows());
  for (std::size_t row = 0; row < rows(); ++row)
    if (!parse_whole(cell(row, *index), values[row])) return bad_cell(row, column, expected);
  return values;
}

Outcome<std::vector<std::int64_t>> CsvTable::integers(std::string_view column) const {
  return exact<std::int64_t>(column, "a whole number");
}

Outcome<std::vector<std::uint64_t>> CsvTable::unsigned_integers(std::string_view column) const {
  return exact<std::uint64_t>(column, "a whole number, not negative");
}

Outcome<std::vector<std::string>> CsvTable::words(std::string_view column) const {
  const Outcome<int> index = require(column);
  if (!index) return index.error();
  std::vector<std::string> values(rows());
  for (std::size_t row = 0; row < rows(); ++row) values[row] = cell(row, *index);
  return values;
}

}  // namespace srd::host
