// SPDX-License-Identifier: Apache-2.0
// What fusion is made of: maps between descriptions, times, sums of information, the file of boards.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include <Eigen/LU>

#include "host/fusion/fusion_file.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/host/boards_of_one_surface.hpp"

namespace srd::host {
namespace {

dsp::SurfaceModel<double> surface_of(int parameters, double lx, double ly, double x0 = 0, double y0 = 0) {
  return {*dsp::ModeList::standard(parameters), lx, ly, x0, y0};
}

Eigen::VectorXd random_vector(Eigen::Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXd out(n);
  for (double& each : out) each = normal(random);
  return out;
}

const BoardArea kArea{150, 100, 260, 180};

TEST(BoardMap, OfTheSameDescriptionChangesNothing) {
  const auto model = surface_of(12, 400, 300, 10, -5);
  const auto map = map_to_board(model, model, {}, kArea);
  ASSERT_TRUE(map.ok());
  EXPECT_TRUE(map->exact);
  EXPECT_LT((map->map - Eigen::MatrixXd::Identity(12, 12)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(map->constant.norm(), 1e-9);
}

// A tilted plane seen by a board that is turned, shifted and raised is a tilted plane.
TEST(BoardMap, OfATurnedBoardGivesTheSameHeights) {
  const auto common = surface_of(3, 400, 300, 20, 30), board = surface_of(3, 250, 333, -5, 8);
  const BoardPlacement placement{.x_mm = 120, .y_mm = -40, .z_mm = 3.5, .turn_rad = 0.7};
  const auto map = map_to_board(common, board, placement, kArea);
  ASSERT_TRUE(map.ok());
  EXPECT_TRUE(map->exact);
  const dsp::Coefficients<double> a = random_vector(3, 1), own = map->map * a + map->constant;
  for (const dsp::Vec2<double>& at : {dsp::Vec2<double>(30, 20), {250, 180}, {100, 50}}) {
    const auto there = placement.to_common(at);
    EXPECT_NEAR(board.height(own, at.x(), at.y()) + 3.5, common.height(a, there.x(), there.y()), 1e-9);
  }
}

// Half a turn about the middle of a tank takes its waves into themselves, odd ones with the other sign.
TEST(BoardMap, OfABoardOnTheOtherSideGivesTheSameWaves) {
  const auto model = surface_of(8, 400, 300);
  const BoardPlacement placement{.x_mm = 400, .y_mm = 300, .turn_rad = M_PI};
  const auto map = map_to_board(model, model, placement, kArea);
  ASSERT_TRUE(map.ok());
  EXPECT_TRUE(map->exact);
  const dsp::Coefficients<double> a = random_vector(8, 2), own = map->map * a + map->constant;
  for (const dsp::Vec2<double>& at : {dsp::Vec2<double>(30, 20), {250, 180}, {100, 50}})
    EXPECT_NEAR(model.height(own, at.x(), at.y()), model.height(a, 400 - at.x(), 300 - at.y()), 1e-9);
}

TEST(BoardMap, OfTooFewModesStatesItsDoubt) {
  const auto common = surface_of(5, 400, 300), board = surface_of(3, 400, 300);
  const auto map = map_to_board(common, board, {}, kArea);
  ASSERT_TRUE(map.ok());
  EXPECT_FALSE(map->exact);
  const dsp::Mode plane_modes[] = {common.modes[0], common.modes[1], common.modes[2]};
  for (int j = 0; j < 5; ++j) {
    const bool described =
        std::find(std::begin(plane_modes), std::end(plane_modes), common.modes[j]) != std::end(plane_modes) &&
        board.modes.index_of(common.modes[j]) >= 0;
    if (described)
      EXPECT_LT(map->doubt.col(j).norm(), 1e-6) << j;
    else
      EXPECT_GT(map->doubt.col(j).norm(), 0.01) << j;
  }
}

TEST(BoardMap, OfModesThatCannotBeToldApartIsRefused) {
  // Over a twentieth of a millimetre a half wave of a metre is a slope.
  const auto model = surface_of(12, 1e6, 1e6);
  EXPECT_FALSE(map_to_board(model, model, {}, {0, 0, 0.05, 0.05}).ok());
}

TEST(TimeTolerance, FollowsTheWavesOverDeepAndShallowWater) {
  // Deep: omega^2 = g k; shallow: omega = k sqrt(g h). Waves of 2 m hardly feel the surface tension.
  const auto model = surface_of(3, 1000, 1e6);
  const double k = M_PI;
  EXPECT_NEAR(fastest_wave(model, 10'000), std::sqrt(9.81 * k), 1e-3 * std::sqrt(9.81 * k));
  EXPECT_NEAR(fastest_wave(model, 5), k * std::sqrt(9.81 * 0.005), 1e-3 * k * std::sqrt(9.81 * 0.005));
  const auto limits = tolerance_of(model, 10'000);
  EXPECT_NEAR(limits.pair_s, 0.2 / fastest_wave(model, 10'000), 1e-12);
  EXPECT_NEAR(tolerance_of(surface_of(1, 400, 300), 80).pair_s, 0.05, 1e-12);  // a level has no waves
}

TimedSurface surface_at(double t, double value, double sd = 0.1, double clock_sd = 0) {
  TimedSurface out;
  out.time_ns = std::llround(t * 1e9);
  out.clock_sd_s = clock_sd;
  out.coefficients = Eigen::VectorXd::Constant(1, value);
  out.covariance = Eigen::MatrixXd::Constant(1, 1, sd * sd);
  return out;
}

TEST(BoardTrack, FollowsAParabolaExactly) {
  BoardTrack track;
  const auto value = [](double t) { return 3 + 2 * t - 40 * t * t; };
  for (const double t : {0.0, 0.021, 0.039, 0.062}) ASSERT_TRUE(track.add(surface_at(t, value(t))));
  for (const double t : {0.014, 0.025, 0.03, 0.04}) {
    const auto at = track.at(std::llround(t * 1e9), 0.02, 0.1);
    ASSERT_TRUE(at);
    EXPECT_NEAR(at->coefficients[0], value(t), 1e-9);
  }
  EXPECT_FALSE(track.at(90'000'000, 0.02, 0.1));  // too far from the last
}

TEST(BoardTrack, BetweenTwoFramesTheNoiseAverages) {
  BoardTrack track;
  (void)track.add(surface_at(0, 1));
  (void)track.add(surface_at(0.02, 2));
  const auto middle = track.at(10'000'000, 0.02, 0.1);
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->coefficients[0], 1.5, 1e-9);
  EXPECT_NEAR(middle->covariance(0, 0), 0.01 / 2, 1e-9);
}

TEST(BoardTrack, AClocksErrorWeighsByTheSurfacesSpeed) {
  BoardTrack track;
  for (const double t : {0.0, 0.02, 0.04}) (void)track.add(surface_at(t, 50 * t, 0.1, 0.002));
  const auto at = track.at(20'000'000, 0.01, 0.1);
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->covariance(0, 0), 0.01 + 0.1 * 0.1, 1e-9);  // 50 mm/s times 2 ms
}

TEST(BoardTrack, AFrameServesOnceAndOneAloneSaysNothingOfItsTime) {
  BoardTrack track;
  (void)track.add(surface_at(0, 1));
  EXPECT_FALSE(track.at(0, 0.02, 0.1));
  (void)track.add(surface_at(0.02, 1));
  EXPECT_FALSE(track.add(surface_at(0.02, 1)));  // time must grow
  ASSERT_TRUE(track.at(0, 0.02, 0.1));
  track.mark_used(0);
  EXPECT_FALSE(track.at(1'000'000, 0.02, 0.1));
  EXPECT_EQ(track.unused(), 1u);
}

// Boards that each see a few combinations of the coefficients: the sum is the joint least squares fit.
TEST(AddedInformation, IsTheJointLeastSquaresFit) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  constexpr int kModes = 6;
  Eigen::MatrixXd all(0, kModes);
  Eigen::VectorXd values(0);
  std::vector<Contribution> parts;
  for (const int seen : {3, 5, 2, 4}) {
    BoardMap map;
    map.map = Eigen::MatrixXd::NullaryExpr(seen, kModes, [&] { return normal(random); });
    map.constant = Eigen::VectorXd::NullaryExpr(seen, [&] { return normal(random); });
    TimedSurface board;
    board.coefficients = Eigen::VectorXd::NullaryExpr(seen, [&] { return normal(random); });
    const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(seen, seen, [&] { return normal(random); });
    board.covariance = root * root.transpose() + Eigen::MatrixXd::Identity(seen, seen);
    const auto part = contribution_of(board, map, {});
    ASSERT_TRUE(part);
    parts.push_back(*part);
    // Rows whitened by the inverse of the covariance's root.
    const Eigen::MatrixXd whitener = Eigen::MatrixXd(board.covariance.llt().matrixL()).inverse();
    Eigen::MatrixXd more(all.rows() + seen, kModes);
    more << all, whitener * map.map;
    Eigen::VectorXd more_values(values.size() + seen);
    more_values << values, whitener * (board.coefficients - map.constant);
    all = more;
    values = more_values;
  }
  std::vector<const Contribution*> pointers;
  for (const Contribution& part : parts) pointers.push_back(&part);
  const auto fused = add_information(pointers, kModes);
  ASSERT_TRUE(fused);
  const Eigen::MatrixXd normal_matrix = all.transpose() * all;
  EXPECT_LT((fused->coefficients - normal_matrix.inverse() * all.transpose() * values).norm(), 1e-9);
  EXPECT_LT((fused->information - normal_matrix).norm(), 1e-9);
  EXPECT_FALSE(add_information(std::span(pointers).first(1), kModes));  // three numbers for six
}

TEST(NormalEquivalent, IsTheTailOfChiSquare) {
  // Upper 0.1 % points of tables: 10.83, 20.52, 32.91 for 1, 5, 12 degrees of freedom; 3.09 of the normal distribution.
  for (const auto& [n, x] : {std::pair{1, 10.828}, {5, 20.515}, {12, 32.909}}) EXPECT_NEAR(normal_equivalent(x, n), 3.09, 0.06);
}

class FusionFile : public testing::Test {
 protected:
  Outcome<void> read(const std::string& text) { return read_fusion_file(folder_.write("boards.toml", text), options); }
  std::string fault(const std::string& text) {
    const auto done = read(text);
    return done.ok() ? "" : done.error().text();
  }
  FusionOptions options;

 private:
  fakes::ScratchFolder folder_;
};

TEST_F(FusionFile, SaysWhereBoardsLie) {
  const auto done = read(R"([fusion]
id = "tank"
pair_ms = 4
[surface]
modes = ["A00", "A10"]
lx_mm = 900
ly_mm = 300
x0_mm = -10
[[board]]
node = "left"
[[board]]
node = "right"
x_mm = 450
z_mm = -1.5
turn_deg = 180
clock_sd_ms = 0.3
)");
  ASSERT_TRUE(done.ok()) << done.error().text();
  EXPECT_EQ(options.id, "tank");
  EXPECT_EQ(options.pair_ms, 4);
  ASSERT_TRUE(options.model);
  EXPECT_EQ(options.model->modes.size(), 2);
  EXPECT_EQ(options.model->x0, -10);
  const BoardInFusion& right = options.boards.at("right");
  EXPECT_EQ(right.placement.x_mm, 450);
  EXPECT_NEAR(right.placement.turn_rad, M_PI, 1e-12);
  EXPECT_EQ(right.clock_sd_ms, 0.3);
  EXPECT_FALSE(options.boards.at("left").clock_sd_ms);
}

TEST_F(FusionFile, WhatIsWrongIsNamed) {
  const std::string two = "[[board]]\nnode = \"a\"\n[[board]]\nnode = \"b\"\n";
  const std::pair<std::string, std::string> cases[] = {
      {"[[board]]\nnode = \"a\"\n", "at least two boards"},
      {two + "[[board]]\nnode = \"a\"\n", "each node once"},
      {two + "[[board]]\nx_mm = 3\n", "node"},
      {two + "[[board]]\nnode = \"a b\"\n", "letters, digits"},
      {two + "turn = 3\n", "turn"},
      {two + "turn_deg = 400\n", "-360 to 360"},
      {two + "[[board]]\nnode = \"fused\"\n", "another name"},
      {"[fusion]\nid = \"a/b\"\n" + two, "letters, digits"},
      {"[surface]\nmodes = [\"A00\"]\nly_mm = 3\n" + two, "lx_mm"},
      {"[surface]\nmodes = [\"Q\"]\nlx_mm = 1\nly_mm = 3\n" + two, "names such as A00"},
      {"[surface]\nparameters = 4\nlx_mm = 1\nly_mm = 3\n" + two, "1, 3, 5, 8 or 12"},
      {"[surface]\nlx_mm = 1\nly_mm = 3\n" + two, "modes"},
      {"[[board]]\nnode = \"a\"\nturn_deg = 90\n[[board]]\nnode = \"b\"\nturn_deg = 90\n", "surface"}};
  for (const auto& [text, words] : cases) {
    options = {};
    EXPECT_NE(fault(text).find(words), std::string::npos) << text << "\n" << fault(text);
  }
}

}  // namespace
}  // namespace srd::host
