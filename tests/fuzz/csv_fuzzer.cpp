// SPDX-License-Identifier: Apache-2.0
// The readers of CSV: a table's cells are all within it.
#include <string>

#include "drivers/support/csv_table.hpp"
#include "host/coefficients/row_writer.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  (void)srd::host::modes_of_header(text.substr(0, text.find('\n')));
  const auto table = srd::CsvTable::parse(text, "input");
  if (!table) return 0;
  std::size_t total = 0;
  for (const std::string& column : table->columns()) {
    (void)table->numbers(column);
    (void)table->integers(column);
    for (std::size_t row = 0; row < table->rows(); ++row) total += table->cell(row, table->index_of(column)).size();
  }
  if (total > size) __builtin_trap();
  return 0;
}
