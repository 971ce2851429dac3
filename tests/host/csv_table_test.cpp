#include "host/table/csv_table.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace srd::host {
namespace {

CsvTable table_of(const std::string& text) {
  auto table = CsvTable::parse(text, "run.csv");
  EXPECT_TRUE(table.ok()) << (table.ok() ? "" : table.error().text());
  return table.ok() ? *table : CsvTable{};
}

TEST(CsvTable, GivesColumnsByNameWithEmptyCells) {
  const CsvTable table = table_of("node,boot,A00\ncam-1,18446744073709551615,80.25\ncam-2,7,\n");
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.words("node").value(), (std::vector<std::string>{"cam-1", "cam-2"}));
  EXPECT_EQ(table.unsigned_integers("boot").value()[0], 18446744073709551615u);
  const auto heights = table.numbers("A00");
  ASSERT_TRUE(heights.ok());
  EXPECT_EQ((*heights)[0], 80.25);
  EXPECT_TRUE(std::isnan((*heights)[1]));
}

TEST(CsvTable, KeepsTimesToTheNanosecond) {
  EXPECT_EQ(table_of("time_ns\n1700000000123456789\n-5\n").integers("time_ns").value(),
            (std::vector<std::int64_t>{1700000000123456789, -5}));
}

TEST(CsvTable, AcceptsWindowsLineEndsBlanksAndAByteOrderMark) {
  const CsvTable table = table_of("\xEF\xBB\xBF" "a , b\r\n 1, 2\r\n\r\n3,4\r\n");
  EXPECT_EQ(table.columns(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(table.numbers("b").value(), (std::vector<double>{2, 4}));
}

TEST(CsvTable, NamesFileLineAndColumnOfABadCell) {
  const CsvTable table = table_of("a,b\n1,2\n\n3,x\n");
  const auto numbers = table.numbers("b");
  ASSERT_FALSE(numbers.ok());
  EXPECT_EQ(numbers.error().where, "run.csv:4");
  EXPECT_NE(numbers.error().what.find("'b'"), std::string::npos);
  EXPECT_EQ(numbers.error().found, "'x'");
  EXPECT_FALSE(table_of("a\nnan\n").numbers("a").ok());
  EXPECT_FALSE(table_of("a\n1e999\n").numbers("a").ok());
  EXPECT_FALSE(table_of("a,b\n,1\n").integers("a").ok());
  EXPECT_FALSE(table_of("a\n-1\n").unsigned_integers("a").ok());
  EXPECT_FALSE(table.numbers("c").ok());
}

TEST(CsvTable, RefusesWhatIsNotATable) {
  EXPECT_FALSE(CsvTable::parse("", "x").ok());
  EXPECT_FALSE(CsvTable::parse("a,b", "x").ok());
  EXPECT_FALSE(CsvTable::parse("a,a\n", "x").ok());
  EXPECT_FALSE(CsvTable::parse("a,\n", "x").ok());
  EXPECT_FALSE(CsvTable::parse("a,b\n\"1\",2\n", "x").ok());
  const auto ragged = CsvTable::parse("a,b\n1,2\n1,2,3\n", "x");
  ASSERT_FALSE(ragged.ok());
  EXPECT_EQ(ragged.error().where, "x:3");
  EXPECT_FALSE(CsvTable::read("no/such/file.csv").ok());
}

TEST(CsvTable, CutAtAnyByteKeepsTheWholeRows) {
  const std::string text = "a,b\n10,20\n11,21\n12,22\n";
  for (std::size_t bytes = 4; bytes <= text.size(); ++bytes) {
    const CsvTable table = table_of(text.substr(0, bytes));
    EXPECT_EQ(table.rows(), (bytes - 4) / 6);
    EXPECT_EQ(table.cut_short(), (bytes - 4) % 6 != 0);
    EXPECT_EQ(table.whole_bytes(), 4 + table.rows() * 6);
    for (std::size_t row = 0; row < table.rows(); ++row)
      EXPECT_EQ(table.numbers("b").value()[row], 20 + static_cast<double>(row));
  }
}

TEST(CsvTable, ReadsAFile) {
  const auto file = std::filesystem::temp_directory_path() / "srd_csv_table_test.csv";
  std::ofstream(file) << "x\n4\n";
  EXPECT_EQ(CsvTable::read(file).value().numbers("x").value(), std::vector<double>{4});
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace srd::host
