// SPDX-License-Identifier: Apache-2.0
// Reads CSV files of this project, also as other programs save them again: one header line of column names, then one row a
// line. A cell is a number, a word or nothing.
// - Between cells: commas; semicolons or tabs when the header has them.
// - Quotes round cells, as R writes them; what is inside is taken as it stands.
// - Decimal commas where cells are not apart by commas. A file that has them has no decimal points: 1.234 would be two numbers.
// - A first column without a name (row names of R and pandas) is passed over; NA and nothing are no number.
// - Windows line ends, a byte order mark, lines without any cell filled.
// Whole files in memory: about the file's size and 16 bytes a cell. Reading from many threads is fine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd {

class CsvTable {
 public:
  // kInput when the file cannot be read, has no header, names a column twice, has a quote without its end or a row of another
  // length; the Problem names file:line. A last line without its line end was cut while being written: it is not a row.
  [[nodiscard]] static Outcome<CsvTable> read(const std::filesystem::path& file);
  // The same from text; name is what Problems call it.
  [[nodiscard]] static Outcome<CsvTable> parse(std::string text, std::string name);

  [[nodiscard]] std::size_t rows() const { return lines_.size(); }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  // -1 when there is no such column.
  [[nodiscard]] int index_of(std::string_view column) const;
  [[nodiscard]] bool has(std::string_view column) const { return index_of(column) >= 0; }
  [[nodiscard]] std::string_view cell(std::size_t row, int column) const;
  // True when the file ended in the middle of a line; whole_bytes() is where the last whole line ends.
  [[nodiscard]] bool cut_short() const { return whole_bytes_ != text_.size(); }
  [[nodiscard]] std::size_t whole_bytes() const { return whole_bytes_; }
  // "file:line" of a row, for messages.
  [[nodiscard]] std::string where(std::size_t row) const;

  // One value a row. kInput with file:line and column for a missing column or a cell that is not of the kind.
  // Finite numbers; NaN where the cell is empty.
  [[nodiscard]] Outcome<std::vector<double>> numbers(std::string_view column) const;
  // Whole numbers to the last digit (times in ns); an empty cell is an error. 5e+09 is 5000000000.
  [[nodiscard]] Outcome<std::vector<std::int64_t>> integers(std::string_view column) const;
  [[nodiscard]] Outcome<std::vector<std::uint64_t>> unsigned_integers(std::string_view column) const;
  [[nodiscard]] Outcome<std::vector<std::string>> words(std::string_view column) const;
  // The first row whose whole number has an exponent, and 16 digits or more: another program rounded it. rows(): none.
  [[nodiscard]] std::size_t first_rounded(std::string_view column) const;

 private:
  struct Cell {
    std::size_t at = 0, size = 0;  // in text_, without quotes and the blanks around it
  };
  class Lines;
  [[nodiscard]] Outcome<void> take_header(const std::vector<Cell>& cells, const std::string& here);
  [[nodiscard]] std::string_view text_of(const Cell& cell) const { return std::string_view(text_).substr(cell.at, cell.size); }
  [[nodiscard]] Outcome<int> require(std::string_view column) const;
  [[nodiscard]] Problem bad_cell(std::size_t row, std::string_view column, std::string expected) const;
  [[nodiscard]] bool number(std::string_view cell, double& value) const;
  template <class T>
  [[nodiscard]] Outcome<std::vector<T>> exact(std::string_view column, const char* expected) const;

  std::string name_;
  std::string text_;
  std::vector<std::string> columns_;
  std::vector<Cell> cells_;         // row by row
  std::vector<std::size_t> lines_;  // line number of each row, from 1
  bool row_names_ = false;          // a first column without a name: not in columns_ and cells_
  bool decimal_comma_ = false;
  std::size_t whole_bytes_ = 0;
};

}  // namespace srd
