// SPDX-License-Identifier: Apache-2.0
#include "host/coefficients/row_reader.hpp"

#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace srd::host {
namespace {

const std::string kHeader =
    "node,boot,sequence,time_ns,clock,status,n_expected,n_found,n_used,mean_error,metric,height_mm,A00,B,sd_"
    "A00,sd_B\n";

std::string row(const std::string& node, const std::string& boot, int sequence, int time, const std::string& status,
                const std::string& values) {
  return node + "," + boot + "," + std::to_string(sequence) + "," + std::to_string(time) + ",monotonic," + status +
         ",20,19,18,0.02,reprojection," + values + "\n";
}

Outcome<CoefficientRun> run_of(const std::string& text, const std::string& node = "") {
  const auto table = CsvTable::parse(text, "run.csv");
  if (!table) return table.error();
  return coefficient_run(*table, "run.csv", node);
}

void expect_problem(const Outcome<CoefficientRun>& run, const std::string& where, const std::string& says) {
  ASSERT_FALSE(run);
  EXPECT_EQ(where, run.error().where);
  EXPECT_NE(std::string::npos, run.error().text().find(says)) << run.error().text();
}

TEST(CoefficientRun, ReadsSurfacesAndFailures) {
  const auto run =
      run_of(kHeader + row("a", "7", 0, 100, "tracking", "80.5,80,1,0.1,0.2") + row("a", "7", 1, 200, "searching", ",,,,"));
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_EQ("a", run->node);
  EXPECT_EQ("reprojection", run->metric);
  EXPECT_EQ(2, run->modes.size());
  ASSERT_EQ(2u, run->rows.size());
  EXPECT_EQ(1u, run->surfaces());
  EXPECT_EQ(80.5, run->rows[0].height_mm);
  EXPECT_EQ(80, run->rows[0].coefficients[0]);
  EXPECT_EQ(0.2, run->rows[0].standard_deviation[1]);
  EXPECT_FALSE(run->rows[1].has_surface());
  EXPECT_TRUE(std::isnan(run->rows[1].height_mm));
}

TEST(CoefficientRun, ReadsSystematicDeviationsWhereTheFileHasThem) {
  std::string header = kHeader;
  header.insert(header.size() - 1, ",sys_A00,sys_B,sys_height_mm");
  std::string known = row("a", "7", 0, 100, "ok", "80.5,80,1,0.1,0.2,0.3,0.4,0.5"),
              unknown = row("a", "7", 1, 200, "ok", "80.5,80,1,0.1,0.2,,,");
  const auto run = run_of(header + known + unknown);
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_EQ(2, run->modes.size());
  EXPECT_EQ(0.3, run->rows[0].systematic_deviation[0]);
  EXPECT_EQ(0.4, run->rows[0].systematic_deviation[1]);
  EXPECT_EQ(0.5, run->rows[0].systematic_height);
  EXPECT_TRUE(std::isnan(run->rows[1].systematic_deviation[0]));
  const auto earlier = run_of(kHeader + row("a", "7", 0, 100, "ok", "80.5,80,1,0.1,0.2"));
  ASSERT_TRUE(earlier);
  EXPECT_TRUE(std::isnan(earlier->rows[0].systematic_height));
}

// The same two frames as srd listen, R, pandas and a German spreadsheet write them.
TEST(CoefficientRun, IsTheSameAfterOtherProgramsSavedItAgain) {
  const std::string ours =
      "node,boot,sequence,time_ns,clock,wall_time_ns,wall_uncertainty_ns,status,n_expected,n_found,n_used,mean_error,metric,"
      "height_mm,A00,B,sd_A00,sd_B\n"
      "cam-1,b00000000000000ff,99999,5000000000,monotonic,1790000000000000000,900,ok,20,19,18,0.02,reprojection,80.5,80,-0."
      "0001,0.1,\n"
      "cam-1,b00000000000000ff,100000,5033333000,monotonic,,,lost,20,3,0,,reprojection,,,,,\n";
  const std::string r =
      "\"\",\"node\",\"boot\",\"sequence\",\"time_ns\",\"clock\",\"wall_time_ns\",\"wall_uncertainty_ns\",\"status\",\"n_"
      "expected\","
      "\"n_found\",\"n_used\",\"mean_error\",\"metric\",\"height_mm\",\"A00\",\"B\",\"sd_A00\",\"sd_B\"\n"
      "\"1\",\"cam-1\",\"b00000000000000ff\",99999,5e+09,\"monotonic\",1.79e+18,900,\"ok\",20,19,18,0.02,\"reprojection\",80.5,"
      "80,-1e-04,0.1,NA\n"
      "\"2\",\"cam-1\",\"b00000000000000ff\",1e+05,5033333000,\"monotonic\",NA,NA,\"lost\",20,3,0,NA,\"reprojection\",NA,NA,NA,"
      "NA,NA\n";
  std::string german = ours;
  for (char& c : german) c = c == ',' ? ';' : c;
  for (const auto& [point, comma] : {std::pair("0.02", "0,02"), {"80.5", "80,5"}, {"-0.0001", "-0,0001"}, {"0.1", "0,1"}})
    german.replace(german.find(point), std::string(point).size(), comma);
  for (std::size_t at = 0; (at = german.find('\n', at)) != std::string::npos; at += 2) german.insert(at, "\r");
  german = "\xEF\xBB\xBF" + german;
  for (const std::string& text : {ours, r, german}) {
    const auto run = run_of(text);
    ASSERT_TRUE(run) << run.error().text() << text;
    EXPECT_TRUE(run->notes.empty());
    ASSERT_EQ(2u, run->rows.size());
    EXPECT_EQ("cam-1", run->node);
    const CoefficientRow& first = run->rows[0];
    EXPECT_EQ("b00000000000000ff", first.boot);
    EXPECT_EQ(99999u, first.sequence);
    EXPECT_EQ(5000000000, first.time_ns);
    EXPECT_EQ(0.02, first.mean_error);
    EXPECT_EQ(80.5, first.height_mm);
    EXPECT_EQ(80, first.coefficients[0]);
    EXPECT_EQ(-0.0001, first.coefficients[1]);
    EXPECT_EQ(0.1, first.standard_deviation[0]);
    EXPECT_TRUE(std::isnan(first.standard_deviation[1]));
    EXPECT_EQ(100000u, run->rows[1].sequence);
    EXPECT_EQ("lost", run->rows[1].status);
    EXPECT_FALSE(run->rows[1].has_surface());
  }
}

TEST(CoefficientRun, TellsOfTimesThatAnotherProgramRounded) {
  std::string text = kHeader + row("a", "7", 0, 100, "tracking", "80,80,1,0.1,0.2");
  text.replace(text.find(",100,"), 5, ",1.70000000012346e+18,");
  const auto run = run_of(text);
  ASSERT_TRUE(run) << run.error().text();
  ASSERT_EQ(1u, run->notes.size());
  EXPECT_NE(std::string::npos, run->notes[0].find("rounded")) << run->notes[0];
}

TEST(CoefficientRun, PutsResentFramesInOrder) {
  const auto run = run_of(kHeader + row("a", "7", 2, 300, "tracking", "80,80,1,0.1,0.2") +
                          row("a", "7", 1, 200, "tracking", "79,79,1,0.1,0.2"));
  ASSERT_TRUE(run);
  EXPECT_EQ(200, run->rows[0].time_ns);
  EXPECT_EQ(79, run->rows[0].coefficients[0]);
}

TEST(CoefficientRun, LeavesOutFramesFromBeforeTheClockStartedAnew) {
  const auto run = run_of(kHeader + row("a", "9", 5, 900, "tracking", "80,80,1,0.1,0.2") +
                          row("a", "3", 0, 10, "tracking", "79,79,1,0.1,0.2"));
  ASSERT_TRUE(run);
  ASSERT_EQ(1u, run->rows.size());
  EXPECT_EQ("3", run->rows[0].boot);
  ASSERT_EQ(1u, run->notes.size());
  EXPECT_NE(std::string::npos, run->notes[0].find("1 frames before boot 3"));
}

TEST(CoefficientRun, DarkFramesAreNoGaps) {
  const std::string lit = "80,80,1,0.1,0.2", none = ",,,,";
  const auto run =
      run_of(kHeader + row("a", "7", 0, 100, "ok", lit) + row("a", "7", 1, 200, "dark", none) +
             row("a", "7", 2, 300, "ok", lit) + row("a", "7", 4, 500, "dark", none) + row("a", "7", 5, 600, "poor_fit", lit));
  ASSERT_TRUE(run);
  ASSERT_EQ(3u, run->rows.size());
  EXPECT_EQ(0u, missing_between(run->rows[0], run->rows[1]));
  EXPECT_EQ(1u, missing_between(run->rows[1], run->rows[2]));  // 3 never came
  EXPECT_EQ((std::vector<std::string>{"2 dark frames are left out"}), run->notes);
  EXPECT_FALSE(run->rows[1].is_flagged());
  EXPECT_TRUE(run->rows[2].is_flagged());
  expect_problem(run_of(kHeader + row("a", "7", 1, 200, "dark", none)), "run.csv:2", "1 dark frames");
}

TEST(CoefficientRun, WrongFilesAreNamedByFileAndLine) {
  const std::string good = row("a", "7", 0, 100, "tracking", "80,80,1,0.1,0.2");
  expect_problem(run_of(""), "run.csv", "no header");
  expect_problem(run_of(kHeader), "run.csv:1", "no frames");
  expect_problem(run_of("node,boot,sequence\na,7,0\n"), "run.csv:1", "no column 'time_ns'");
  expect_problem(run_of(kHeader + good + row("a", "7", 1, 200, "tracking", "80,high,1,0.1,0.2")), "run.csv:3", "'high'");
  expect_problem(run_of(kHeader + good + row("a", "7", 1, 200, "tracking", "80,80,nan,0.1,0.2")), "run.csv:3", "'B'");
  expect_problem(run_of(kHeader + good + row("a", "7", 1, 200, "tracking", "80,80,,0.1,0.2")), "run.csv:3",
                 "some of its coefficients");
  expect_problem(run_of(kHeader + good + good), "run.csv:3", "twice");
  std::string no_modes = kHeader;
  no_modes.replace(no_modes.find("A00,B,sd_A00,sd_B"), 17, "h0,h1,w0,w1");
  expect_problem(run_of(no_modes + good), "run.csv:1", "no list of modes");
  std::string no_sd = kHeader;
  no_sd.replace(no_sd.find("sd_B"), 4, "spare");
  expect_problem(run_of(no_sd + good), "run.csv:1", "no column 'sd_B'");
}

TEST(CoefficientRun, SeveralNodesMustBeNamed) {
  const std::string text =
      kHeader + row("a", "7", 0, 100, "tracking", "80,80,1,0.1,0.2") + row("b", "8", 0, 100, "tracking", "70,70,1,0.1,0.2");
  expect_problem(run_of(text), "run.csv", "a, b");
  expect_problem(run_of(text, "c"), "run.csv", "no node 'c'");
  const auto run = run_of(text, "b");
  ASSERT_TRUE(run);
  EXPECT_EQ(70, run->rows.at(0).coefficients[0]);
}

TEST(CoefficientRun, OnlyFailuresSayTheirStatuses) {
  const auto run = run_of(kHeader + row("a", "7", 0, 100, "searching", ",,,,") + row("a", "7", 1, 200, "lost", ",,,,"));
  ASSERT_TRUE(run);
  const auto usable = require_surface(*run);
  ASSERT_FALSE(usable);
  EXPECT_EQ("run.csv:2", usable.error().where);
  EXPECT_EQ("2 frames: 1 lost 1 searching", usable.error().found);
}

}  // namespace
}  // namespace srd::host
