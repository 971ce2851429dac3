// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/csv_table.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "drivers/support/text_file.hpp"

namespace srd {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::size_t kDigitsKept = 15;  // of a number in programs that know floating point only

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// "80,25", "-1,5e-3": digits, one comma, digits.
bool has_decimal_comma(std::string_view cell) {
  const std::size_t comma = cell.find(',');
  return comma != std::string_view::npos && comma > 0 && comma + 1 < cell.size() && is_digit(cell[comma - 1]) &&
         is_digit(cell[comma + 1]) && cell.find_first_not_of("0123456789+-,eE") == std::string_view::npos;
}

// "1.70000000012346e+18" as its digits, "1700000000123460000"; empty when it is no whole number of at most 20 digits.
std::string written_out(std::string_view cell) {
  const std::size_t e = cell.find_first_of("eE");
  if (e == std::string_view::npos) return {};
  std::string_view mantissa = cell.substr(0, e);
  const std::string_view exponent = cell.substr(e + 1);
  const auto power = parse_number<int>(exponent);
  if (!power || *power < 0 || *power > 20) return {};
  std::string digits;
  if (mantissa.starts_with('-')) {
    digits = "-";
    mantissa.remove_prefix(1);
  }
  const std::size_t point = std::min(mantissa.find_first_of(".,"), mantissa.size());
  const std::string_view whole = mantissa.substr(0, point);
  std::string_view fraction = mantissa.substr(std::min(point + 1, mantissa.size()));
  while (fraction.ends_with('0')) fraction.remove_suffix(1);
  if (whole.empty() || !std::all_of(whole.begin(), whole.end(), is_digit) ||
      !std::all_of(fraction.begin(), fraction.end(), is_digit) || fraction.size() > static_cast<std::size_t>(*power))
    return {};
  digits += std::string(whole) + std::string(fraction);
  return digits.append(static_cast<std::size_t>(*power) - fraction.size(), '0');
}

}  // namespace

// The lines of a text as cells.
class CsvTable::Lines {
 public:
  Lines(const std::string& text, std::size_t at, char separator) : text_(text), at_(at), separator_(separator) {}
  enum class Next : std::uint8_t { kLine, kNoMore, kBadQuote };
  // kNoMore: what is left, if anything, has no line end.
  Next next(std::vector<Cell>& cells) {
    cells.clear();
    line_ += breaks_;
    breaks_ = 1;
    std::size_t at = at_;
    for (;;) {
      while (at < text_.size() && is_blank(text_[at]) && text_[at] != separator_) ++at;
      Cell cell{at, 0};
      if (at < text_.size() && text_[at] == '"') {
        cell.at = ++at;
        // Two quotes are one of the cell.
        for (;; ++at) {
          at = text_.find('"', at);
          // In the last line it was cut while being written; elsewhere it would swallow the rows below.
          if (at == std::string::npos) return text_.find('\n', cell.at) == std::string::npos ? Next::kNoMore : Next::kBadQuote;
          if (at + 1 < text_.size() && text_[at + 1] == '"')
            ++at;
          else
            break;
        }
        cell.size = at++ - cell.at;
        breaks_ += static_cast<std::size_t>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(cell.at),
                                                       text_.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
        while (at < text_.size() && is_blank(text_[at]) && text_[at] != separator_) ++at;
        if (at < text_.size() && text_[at] != separator_ && text_[at] != '\n') return Next::kBadQuote;
      } else {
        while (at < text_.size() && text_[at] != separator_ && text_[at] != '\n') {
          if (text_[at] == '"') return Next::kBadQuote;
          ++at;
        }
        std::size_t end = at;
        while (end > cell.at && is_blank(text_[end - 1])) --end;
        cell.size = end - cell.at;
      }
      if (at >= text_.size()) return Next::kNoMore;
      cells.push_back(cell);
      if (text_[at++] == '\n') break;
    }
    at_ = at;
    return Next::kLine;
  }
  [[nodiscard]] std::size_t line() const { return line_; }  // of the last call, from 1
  [[nodiscard]] std::size_t at() const { return at_; }      // where the next one begins

 private:
  const std::string& text_;
  std::size_t at_;
  char separator_;
  std::size_t line_ = 0, breaks_ = 1;
};

Outcome<CsvTable> CsvTable::read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text;
  if (in) text.assign(std::istreambuf_iterator<char>(in), {});
  if (!in || in.bad())
    return Problem{.what = "cannot read the file", .where = file.string(), .expected = "a CSV file with a header line"};
  return parse(std::move(text), file.string());
}

Outcome<void> CsvTable::take_header(const std::vector<Cell>& cells, const std::string& here) {
  row_names_ = cells.size() > 1 && cells[0].size == 0;
  std::set<std::string> seen;
  for (std::size_t i = row_names_ ? 1 : 0; i < cells.size(); ++i) {
    const std::string column(text_of(cells[i]));
    if (column.empty())
      return Problem{.what = "a column without a name", .where = here, .expected = "a header line of column names"};
    if (!seen.insert(column).second)
      return Problem{.what = "column '" + column + "' is there twice", .where = here, .expected = "different names"};
    columns_.push_back(column);
  }
  return {};
}

Outcome<CsvTable> CsvTable::parse(std::string text, std::string name) {
  CsvTable table;
  table.name_ = std::move(name);
  table.text_ = std::move(text);
  const std::string& all = table.text_;
  if (all.starts_with("\xFF\xFE") || all.starts_with("\xFE\xFF"))
    return Problem{.what = "the file is UTF-16",
                   .where = table.name_,
                   .expected = "a CSV file in UTF-8",
                   .advice = "save it as 'CSV UTF-8'"};
  const std::size_t begin = all.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  const std::string_view header = std::string_view(all).substr(begin, all.find('\n', begin) - begin);
  const auto in_header = [&](char c) { return header.find(c) != std::string_view::npos; };
  const char separator = in_header(';') ? ';' : in_header('\t') && !in_header(',') ? '\t' : ',';
  Lines lines(all, begin, separator);
  std::vector<Cell> cells;
  table.whole_bytes_ = begin;
  for (;;) {
    const Lines::Next next = lines.next(cells);
    if (next == Lines::Next::kNoMore) break;
    const std::string here = table.name_ + ":" + std::to_string(lines.line());
    if (next == Lines::Next::kBadQuote)
      return Problem{.what = "a quote inside a cell, or without its other one",
                     .where = here,
                     .expected = "quotes round whole cells, or none"};
    table.whole_bytes_ = lines.at();
    if (lines.line() == 1) {
      if (auto done = table.take_header(cells, here); !done) return done.error();
      continue;
    }
    if (std::all_of(cells.begin(), cells.end(), [](const Cell& c) { return c.size == 0; }) &&
        (cells.size() == 1 || separator != ','))
      continue;
    const std::size_t names = table.row_names_ ? 1 : 0;
    if (cells.size() != table.columns_.size() + names)
      return Problem{.what = "a row of another length than the header",
                     .where = here,
                     .expected = std::to_string(table.columns_.size() + names) + " cells",
                     .found = std::to_string(cells.size())};
    if (separator != ',' && !table.decimal_comma_)
      table.decimal_comma_ =
          std::any_of(cells.begin(), cells.end(), [&](const Cell& c) { return has_decimal_comma(table.text_of(c)); });
    table.cells_.insert(table.cells_.end(), cells.begin() + static_cast<std::ptrdiff_t>(names), cells.end());
    table.lines_.push_back(lines.line());
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
  return text_of(cells_[row * columns_.size() + static_cast<std::size_t>(column)]);
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

bool CsvTable::number(std::string_view cell, double& value) const {
  std::string with_point(cell);
  if (decimal_comma_) {
    if (cell.find('.') != std::string_view::npos) return false;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
  }
  const auto parsed = parse_number<double>(with_point);
  value = parsed.value_or(value);
  return parsed.has_value();
}

Outcome<std::vector<double>> CsvTable::numbers(std::string_view column) const {
  const Outcome<int> index = require(column);
  if (!index) return index.error();
  std::vector<double> values(rows(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t row = 0; row < rows(); ++row) {
    const std::string_view text = cell(row, *index);
    if (text.empty() || text == "NA") continue;
    if (!number(text, values[row]))
      return bad_cell(row, column,
                      decimal_comma_ ? "a finite number with a decimal comma, as others in this file, or nothing"
                                     : "a finite number or nothing");
  }
  return values;
}

template <class T>
Outcome<std::vector<T>> CsvTable::exact(std::string_view column, const char* expected) const {
  const Outcome<int> index = require(column);
  if (!index) return index.error();
  std::vector<T> values(rows());
  for (std::size_t row = 0; row < rows(); ++row) {
    const std::string_view text = cell(row, *index);
    auto value = parse_number<T>(text);
    if (!value) value = parse_number<T>(written_out(text));
    if (!value) return bad_cell(row, column, expected);
    values[row] = *value;
  }
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

std::size_t CsvTable::first_rounded(std::string_view column) const {
  const int index = index_of(column);
  for (std::size_t row = 0; index >= 0 && row < rows(); ++row)
    if (written_out(cell(row, index)).size() > kDigitsKept) return row;
  return rows();
}

}  // namespace srd
