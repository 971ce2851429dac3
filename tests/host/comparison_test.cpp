// SPDX-License-Identifier: Apache-2.0
#include "host/compare/comparison.hpp"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "drivers/support/text_file.hpp"
#include "host/compare/command.hpp"
#include "tests/fakes/command_run.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/host/csv_header.hpp"

namespace srd::host {
namespace {

// Four frames; the second has no surface. Offsets from the truth: A00 +0.1, -0.1, +0.1; B +0.2 always.
CoefficientRun estimated() {
  std::string text = kThreeModesHeader;
  const double off[] = {0.1, 0, -0.1, 0.1};
  for (int i = 0; i < 4; ++i) {
    text += "n,1," + std::to_string(i) + "," + std::to_string(1000 + i) + ",monotonic,";
    text += i == 1 ? "lost,9,0,0,,,,,,,,,\n"
                   : "tracking,9,9,9,0.01,reprojection,80," + number_text(80 + i + off[i]) + ",1.2,2,0.1,0.1,0.1\n";
  }
  const auto table = CsvTable::parse(text, "run.csv");
  EXPECT_TRUE(table);
  const auto run = coefficient_run(*table, "run.csv", "");
  EXPECT_TRUE(run) << run.error().text();
  return *run;
}

Truth truth(std::int64_t first_time) {
  Truth t;
  t.modes = *dsp::ModeList::standard(3);
  for (int i = 0; i < 4; ++i) {
    TruthRow row;
    row.frame = static_cast<std::uint64_t>(i);
    row.time_ns = first_time + i;
    row.coefficients.resize(3);
    row.coefficients << 80 + i, 1, 2;
    t.rows.push_back(row);
  }
  return t;
}

RunGeometry square() {
  RunGeometry g;
  g.model = {*dsp::ModeList::standard(3), 100, 100, 0, 0};
  g.pattern = {0, 100, 0, 100};
  g.corners = {{0, 0}, {100, 0}, {0, 100}, {100, 100}};
  g.places = g.corners;
  return g;
}

TEST(Comparison, GivesTheErrorsThatWerePutIn) {
  const auto c = compare(estimated(), truth(1000), "truth.csv", MatchBy::kTime, square());
  ASSERT_TRUE(c) << c.error().text();
  EXPECT_EQ(4u, c->matched);
  ASSERT_EQ(3u, c->frames.size());
  EXPECT_NEAR(0.1, c->summary[0].rms, 1e-12);
  EXPECT_NEAR(0.1 / 3, c->summary[0].mean, 1e-12);
  EXPECT_NEAR(1.0, c->summary[0].normalised, 1e-12);
  EXPECT_NEAR(0.2, c->summary[1].largest, 1e-12);
  EXPECT_NEAR(0.0, c->summary[2].rms, 1e-12);
  // At the centre X/Lx = 1/2: +-0.1 + 0.1. Over the corners: +-0.1 at X = 0 and +-0.1 + 0.2 at X = 100.
  EXPECT_NEAR(std::sqrt((0.04 + 0 + 0.04) / 3), c->height_rms, 1e-12);
  EXPECT_NEAR(std::sqrt((0.01 + 0.09) / 2), c->frames[0].surface_rms, 1e-12);
  EXPECT_NEAR(std::sqrt((0.01 + 0.01) / 2), c->frames[1].surface_rms, 1e-12);
  EXPECT_NEAR(std::sqrt((0.05 + 0.01 + 0.05) / 3), c->surface_rms, 1e-12);
  EXPECT_NE(1u, c->worst);
}

TEST(Comparison, WorksOnTheModesThatBothHave) {
  Truth level = truth(1000);
  level.modes = *dsp::ModeList::standard(1);
  for (TruthRow& row : level.rows) row.coefficients.conservativeResize(1);
  const auto c = compare(estimated(), level, "truth.csv", MatchBy::kTime, square());
  ASSERT_TRUE(c);
  EXPECT_EQ(1, c->modes.size());
  // The surface counts every mode: C = 2 is not in the truth, so it is an error of the surface.
  EXPECT_GT(c->surface_rms, 1.0);
  EXPECT_NE(std::string::npos, comparison_text(estimated(), level, *c, square()).find("C: not in the truth"));
}

TEST(Comparison, MatchesByTimeOnlyWhenEqual) {
  const auto by_time = compare(estimated(), truth(5000), "truth.csv", MatchBy::kTime, std::nullopt);
  ASSERT_FALSE(by_time);
  EXPECT_NE(std::string::npos, by_time.error().advice.find("--by-order"));
  const auto by_order = compare(estimated(), truth(5000), "truth.csv", MatchBy::kOrder, std::nullopt);
  ASSERT_TRUE(by_order);
  EXPECT_NEAR(0.1, by_order->summary[0].rms, 1e-12);
  EXPECT_TRUE(std::isnan(by_order->surface_rms));
  Truth longer = truth(5000);
  longer.rows.push_back(longer.rows.back());
  EXPECT_FALSE(compare(estimated(), longer, "truth.csv", MatchBy::kOrder, std::nullopt));
}

class CompareCommand : public testing::Test {
 protected:
  void SetUp() override {
    const auto file = [&](const char* name) { return (folder_ / name).string(); };
    std::string text = kThreeModesHeader;
    for (int i = 0; i < 3; ++i)
      text += "n,1," + std::to_string(i) + "," + std::to_string(1000 + i) + ",monotonic,tracking,9,9,9,0.01,reprojection,80," +
              number_text(80.05 + i) + ",1,2,0.1,0.1,0.1\n";
    ASSERT_TRUE(write_text_file(file("run.csv"), text));
    ASSERT_TRUE(write_truth(file("truth.csv"), truth(1000)));
    ASSERT_TRUE(write_text_file(file("points.txt"), "0 0 0\n100 0 0\n0 100 0\n100 100 0\n"));
  }

  int run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"compare", (folder_ / "run.csv").string(), (folder_ / "truth.csv").string()});
    const fakes::CommandRun done = fakes::run_command(add_compare_command, std::move(arguments));
    said_ = done.out + done.err;
    return done.exit;
  }

  fakes::ScratchFolder scratch_;
  const std::filesystem::path& folder_ = scratch_.path();
  std::string said_;
};

TEST_F(CompareCommand, PrintsAndJudgesTheSurface) {
  const std::vector<std::string> geometry = {"--lx", "100", "--ly", "100", "--points", (folder_ / "points.txt").string()};
  EXPECT_EQ(0, run(geometry));
  EXPECT_NE(std::string::npos, said_.find("rms 0.0500 mm")) << said_;
  std::vector<std::string> strict = geometry;
  strict.insert(strict.end(), {"--max-rms", "0.049"});
  EXPECT_EQ(3, run(strict));
  strict.back() = "0.051";
  EXPECT_EQ(0, run(strict));
}

TEST_F(CompareCommand, TakesTheModelFileBesideTheCoefficients) {
  NodeModel node{.node = "n", .model = square().model, .refractive_index = 1.333, .pattern = square().pattern};
  ASSERT_TRUE(write_model_file(model_file_path(folder_ / "run.csv"), {{node}}));
  EXPECT_EQ(0, run({"--max-rms", "0.051"})) << said_;
  node.model.modes = *dsp::ModeList::standard(5);
  ASSERT_TRUE(write_model_file(model_file_path(folder_ / "run.csv"), {{node}}));
  EXPECT_EQ(2, run({}));
  EXPECT_NE(std::string::npos, said_.find("other modes")) << said_;
}

TEST_F(CompareCommand, RefusesALimitItCannotJudge) {
  EXPECT_EQ(0, run({}));
  EXPECT_EQ(2, run({"--max-rms", "1"}));
}

}  // namespace
}  // namespace srd::host
