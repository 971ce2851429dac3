// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/csv_table.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace srd {
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
  const CsvTable table = table_of(
      "\xEF\xBB\xBF"
      "a , b\r\n 1, 2\r\n\r\n3,4\r\n");
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
  EXPECT_FALSE(CsvTable::parse("a,b\n1\"2,2\n", "x").ok());
  EXPECT_FALSE(CsvTable::parse("a,b\n\"1\"2,2\n", "x").ok());
  const auto wide = CsvTable::parse(
      "\xFF\xFE"
      "a",
      "x");
  ASSERT_FALSE(wide.ok());
  EXPECT_NE(wide.error().text().find("UTF-16"), std::string::npos);
  const auto ragged = CsvTable::parse("a,b\n1,2\n1,2,3\n", "x");
  ASSERT_FALSE(ragged.ok());
  EXPECT_EQ(ragged.error().where, "x:3");
  EXPECT_FALSE(CsvTable::read("no/such/file.csv").ok());
}

// What write.csv of R and to_csv of pandas make of node,boot,time_ns,A00,B.
TEST(CsvTable, ReadsWhatRAndPandasSavedAgain) {
  const CsvTable r = table_of(
      "\"\",\"node\",\"boot\",\"time_ns\",\"A00\",\"B\"\n"
      "\"1\",\"cam-1\",\"b00000000000000ff\",5e+09,80.25,NA\n"
      "\"2\",\"cam, 2\",\"b00000000000000ff\",5033333000,-1e-04,2\n");
  const CsvTable pandas = table_of(
      ",node,boot,time_ns,A00,B\n0,cam-1,b00000000000000ff,5000000000,80.25,\n"
      "1,\"cam, 2\",b00000000000000ff,5033333000,-0.0001,2.0\n");
  for (const CsvTable* table : {&r, &pandas}) {
    EXPECT_EQ(table->columns(), (std::vector<std::string>{"node", "boot", "time_ns", "A00", "B"}));
    EXPECT_EQ(table->words("node").value(), (std::vector<std::string>{"cam-1", "cam, 2"}));
    EXPECT_EQ(table->words("boot").value()[1], "b00000000000000ff");
    EXPECT_EQ(table->integers("time_ns").value(), (std::vector<std::int64_t>{5000000000, 5033333000}));
    EXPECT_EQ(table->numbers("A00").value(), (std::vector<double>{80.25, -0.0001}));
    EXPECT_TRUE(std::isnan(table->numbers("B").value()[0]));
    EXPECT_EQ(table->numbers("B").value()[1], 2);
    EXPECT_EQ(table->first_rounded("time_ns"), table->rows());
  }
}

TEST(CsvTable, ReadsWhatAGermanSpreadsheetSavedAgain) {
  const CsvTable table = table_of(
      "\xEF\xBB\xBF"
      "node;time_ns;A00;B\r\ncam-1;5000000000;80,25;\r\n"
      "\"cam-2\";5033333000;-1,5E-3;7\r\n;;;\r\n");
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.words("node").value()[1], "cam-2");
  EXPECT_EQ(table.integers("time_ns").value()[1], 5033333000);
  EXPECT_EQ(table.numbers("A00").value(), (std::vector<double>{80.25, -0.0015}));
  EXPECT_EQ(table.numbers("B").value()[1], 7);
  EXPECT_EQ(table_of("a\tb\n1,5\t2\n").numbers("a").value()[0], 1.5);
  EXPECT_EQ(table_of("a;b\n1.5;2\n").numbers("a").value()[0], 1.5);
}

// 1.234 is 1.234 in one half of the world and 1234 in the other.
TEST(CsvTable, RefusesDecimalPointsBesideDecimalCommas) {
  const auto mixed = table_of("a;b\n1,5;x\n1.234;y\n").numbers("a");
  ASSERT_FALSE(mixed.ok());
  EXPECT_EQ(mixed.error().where, "run.csv:3");
  EXPECT_NE(mixed.error().text().find("decimal comma"), std::string::npos);
  EXPECT_FALSE(table_of("a;b\n1.234,5;x\n").numbers("a").ok());
}

TEST(CsvTable, SaysWhereTimesWereRounded) {
  const CsvTable table = table_of("t,u\n5e+09,1\n1.70000000012346e+18,2\n");
  EXPECT_EQ(table.integers("t").value()[1], 1700000000123460000);
  EXPECT_EQ(table.first_rounded("t"), 1u);
  EXPECT_FALSE(table_of("t\n1.5e0\n").integers("t").ok());
  EXPECT_FALSE(table_of("t\n1e30\n").integers("t").ok());
  EXPECT_FALSE(table_of("t\ne5\n").integers("t").ok());
}

TEST(CsvTable, QuotedCellsMayHoldSeparatorsQuotesAndLineEnds) {
  const CsvTable table = table_of("a,b\n\"x\ny,\"\"z\"\"\",1\nq,w\n");
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.words("a").value()[0], "x\ny,\"\"z\"\"");
  EXPECT_EQ(table.where(1), "run.csv:4");
  EXPECT_TRUE(table_of("a,b\n1,2\n\"3,4").cut_short());
  const auto open = CsvTable::parse("a,b\n1,2\n\"3,4\n5,6\n", "x");
  ASSERT_FALSE(open.ok()) << "would leave out all rows below";
  EXPECT_EQ(open.error().where, "x:3");
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
}  // namespace srd
