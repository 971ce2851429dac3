// Reads the CSV files of this project: one header line of column names, then one row a line, cells apart by commas.
// A cell is a number, a word or nothing; there are no quotes. Windows line ends and a byte order mark are accepted.
// Whole files in memory: about the file's size and 8 bytes a cell. Reading from many threads is fine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd::host {

class CsvTable {
 public:
  // kInput when the file cannot be read, has no header, names a column twice, has a quote or a row of another length;
  // the Problem names file:line. A last line without its line end was cut while being written: it is not a row.
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
  [[nodiscard]] bool cut_short() const { return whole_bytes_ != file_bytes_; }
  [[nodiscard]] std::size_t whole_bytes() const { return whole_bytes_; }
  // "file:line" of a row, for messages.
  [[nodiscard]] std::string where(std::size_t row) const;

  // One value a row. kInput with file:line and column for a missing column or a cell that is not of the kind.
  // Finite numbers; NaN where the cell is empty.
  [[nodiscard]] Outcome<std::vector<double>> numbers(std::string_view column) const;
  // Whole numbers to the last digit (times in ns, boot ids); an empty cell is an error.
  [[nodiscard]] Outcome<std::vector<std::int64_t>> integers(std::string_view column) const;
  [[nodiscard]] Outcome<std::vector<std::uint64_t>> unsigned_integers(std::string_view column) const;
  [[nodiscard]] Outcome<std::vector<std::string>> words(std::string_view column) const;

 private:
  [[nodiscard]] Outcome<int> require(std::string_view column) const;
  [[nodiscard]] Problem bad_cell(std::size_t row, std::string_view column, std::string expected) const;
  template <class T>
  [[nodiscard]] Outcome<std::vector<T>> exact(std::string_view column, const char* expected) const;

  std::string name_;
  std::string text_;
  std::vector<std::string> columns_;
  std::vector<std::size_t> cells_;   // where each cell starts in text_, row by row; ends are found by the separator
  std::vector<std::size_t> lines_;   // line number of each row, from 1
  std::size_t file_bytes_ = 0, whole_bytes_ = 0;
};

}  // namespace srd::host
