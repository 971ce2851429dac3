// SPDX-License-Identifier: Apache-2.0
#include "host/fusion/fusion.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/host/boards_of_one_surface.hpp"

namespace srd::host {
namespace {

struct FusionRun {
  KeptFrames kept;
  std::vector<std::string> lines;
  std::map<std::string, BoardCounts> counts;
  std::vector<double> told_at;  // true time of each line
};

// Frames of all boards in the order of their true times, from 0 to the end. change(t, boards) may move things on the way.
template <class Truth, class Change>
FusionRun run_boards(std::vector<BoardOfTest> boards, double end_s, unsigned seed, const Truth& truth, const Change& change,
                     FusionOptions options = {}) {
  FusionRun out;
  BoardsOfOneSurface world(seed);
  double now = 0;
  options.sinks = {&out.kept};
  options.notify = [&](const std::string& line) {
    out.lines.push_back(line);
    out.told_at.push_back(now);
  };
  Fusion fusion(options);
  std::vector<std::int64_t> next(boards.size(), 0);
  const auto time_of = [&](std::size_t i) { return boards[i].phase_s + static_cast<double>(next[i]) / boards[i].hz; };
  for (;;) {
    std::size_t first = 0;
    for (std::size_t i = 1; i < boards.size(); ++i)
      if (time_of(i) < time_of(first)) first = i;
    now = time_of(first);
    if (now > end_s) break;
    change(now, boards);
    const BoardOfTest& board = boards[first];
    const auto k = next[first]++;
    if (board.noise > 0) {
      EXPECT_TRUE(fusion.write(boot_of(board.name), static_cast<std::uint64_t>(k), world.frame(board, k, truth)).ok());
    }
  }
  EXPECT_TRUE(fusion.finish().ok());
  out.counts = fusion.counts();
  return out;
}

void nothing_changes(double, std::vector<BoardOfTest>&) {}

Eigen::VectorXd error_of(const proto::CoefficientFrame& frame) {
  return frame.coefficients.cast<double>() - swash(BoardsOfOneSurface::seconds(frame));
}

std::uint64_t unpaired(const FusionRun& run, const std::string& name, Unpaired cause) {
  return run.counts.at(name).unpaired[static_cast<std::size_t>(cause)];
}

TEST(Fusion, OfBoardsInStepIsAsGoodAsAllTheirCornersTogether) {
  const auto run =
      run_boards({{.name = "a"}, {.name = "b", .noise = 0.7}, {.name = "c", .noise = 1.5}}, 20, 1, swash, nothing_changes);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(5, 5);
  for (const double noise : {1.0, 0.7, 1.5}) information += BoardsOfOneSurface::covariance(noise).inverse();
  double square = 0;
  ASSERT_GT(run.kept.frames.size(), 990u);
  for (const auto& frame : run.kept.frames) {
    EXPECT_EQ(frame.status, proto::FrameStatus::kOk);
    const Eigen::VectorXd error = error_of(frame);
    square += error.dot(information * error) / 5 / static_cast<double>(run.kept.frames.size());
    EXPECT_EQ(frame.corners_used, 600u);
    EXPECT_TRUE(proto::valid(frame));  // records take it
  }
  EXPECT_NEAR(square, 1, 0.08);  // 5000 draws, and 0.1 ms of each clock
  EXPECT_EQ(run.counts.at("a").used, run.kept.frames.size());
  EXPECT_TRUE(run.lines.empty()) << run.lines.front();
}

// Free-running boards whose clocks are wrong by what they say: errors over many draws against what a joint estimate that
// knows those deviations can reach.
TEST(Fusion, OfBoardsWithUnsureClocksIsAsGoodAsTheirDeviationsAllow) {
  constexpr int kRuns = 60;
  double fused_square = 0, expected = 0, best_board = 0, normalised = 0;
  std::size_t count = 0;
  BoardsOfOneSurface world(99);
  for (int i = 0; i < kRuns; ++i) {
    std::vector<BoardOfTest> boards{{.name = "a", .phase_s = 0.004, .sd_s = 2e-4},
                                    {.name = "b", .phase_s = 0.011, .sd_s = 3e-3},
                                    {.name = "c", .hz = 63, .phase_s = 0.001, .sd_s = 3e-3}};
    for (BoardOfTest& board : boards) board.offset_s = board.sd_s * world.normal();
    const auto run = run_boards(boards, 3, static_cast<unsigned>(i), swash, nothing_changes);
    for (const auto& frame : run.kept.frames) {
      const double t = BoardsOfOneSurface::seconds(frame);
      if (t < 0.1 || t > 2.8) continue;
      ASSERT_EQ(frame.status, proto::FrameStatus::kOk);
      const Eigen::VectorXd speed = (swash(t + 1e-4) - swash(t - 1e-4)) / 2e-4;
      const Eigen::MatrixXd c = BoardsOfOneSurface::covariance(1);
      Eigen::MatrixXd information = Eigen::MatrixXd::Zero(5, 5);
      for (const BoardOfTest& board : boards)
        information += (c + board.sd_s * board.sd_s * speed * speed.transpose()).inverse();
      fused_square += error_of(frame).squaredNorm();
      normalised += (proto::expand(frame.information) * error_of(frame)).squaredNorm() / 5;
      expected += information.inverse().trace();
      best_board += (c + 4e-8 * speed * speed.transpose()).trace();
      ++count;
    }
  }
  EXPECT_GT(count, 60u * 100u);
  EXPECT_LT(fused_square, 0.7 * best_board);
  EXPECT_LT(std::sqrt(fused_square / expected), 1.05);
  EXPECT_NEAR(normalised / static_cast<double>(count), 1, 0.15);  // the clocks err once a run
}

TEST(Fusion, AClockThatIsTooUnsureForTheWavesIsLeftOutAndTold) {
  const auto run = run_boards({{.name = "a", .offset_s = 2e-4, .sd_s = 2e-4},
                               {.name = "b", .offset_s = -1e-3, .sd_s = 1e-3},
                               {.name = "c", .offset_s = 0.04, .sd_s = 0.04}},
                              5, 2, swash, nothing_changes);
  EXPECT_EQ(run.counts.at("c").used, 0u);
  EXPECT_EQ(unpaired(run, "c", Unpaired::kClockUnsure), 251u);
  EXPECT_GT(run.counts.at("b").used, 240u);
  ASSERT_EQ(run.lines.size(), 1u);
  EXPECT_NE(run.lines[0].find("node c is left out: its clock's standard deviation is 40 ms"), std::string::npos)
      << run.lines[0];
}

TEST(Fusion, ABoardWithoutWallTimeIsToldWhatToDo) {
  const auto run = run_boards({{.name = "a"}, {.name = "b", .sd_s = 0}}, 2, 3, swash, nothing_changes);
  EXPECT_EQ(run.counts.at("b").used, 0u);
  ASSERT_EQ(run.lines.size(), 1u);
  EXPECT_NE(run.lines[0].find("chrony"), std::string::npos) << run.lines[0];
}

TEST(Fusion, GoesOnWithTheBoardsThatAreThere) {
  const auto run = run_boards({{.name = "a"}, {.name = "b"}}, 12, 4, swash, [](double t, std::vector<BoardOfTest>& boards) {
    boards[0].noise = t > 4 && t < 8 ? 0 : 1;  // no frames of it
  });
  int both = 0, one = 0;
  for (const auto& frame : run.kept.frames) {
    EXPECT_EQ(frame.status, proto::FrameStatus::kOk);
    both += frame.corners_used == 400;
    one += frame.corners_used == 200;
    EXPECT_LT(error_of(frame).norm(), 0.15);
  }
  EXPECT_GT(both, 390);
  EXPECT_GT(one, 170);
  EXPECT_LT(one, 230);
}

TEST(Fusion, AFastBoardServesTheMomentsOfASlowOne) {
  const auto run =
      run_boards({{.name = "fast", .hz = 200, .phase_s = 0.0013}, {.name = "slow", .hz = 25}}, 8, 5, swash, nothing_changes);
  EXPECT_NEAR(static_cast<double>(run.kept.frames.size()), 200, 3);
  EXPECT_EQ(run.counts.at("fast").used, run.counts.at("slow").used);
  EXPECT_NEAR(static_cast<double>(unpaired(run, "fast", Unpaired::kNoMoment)), 1400, 40);
}

TEST(Fusion, ACameraThatTurnsIsToldAndLeftOut) {
  Eigen::VectorXd tilt(5);
  tilt << 0.2, 1.0, -0.3, 0.1, 0.05;
  const auto run =
      run_boards({{.name = "a", .leak = 0.004}, {.name = "b", .leak = -0.003}, {.name = "c", .leak = 0.002}}, 60, 6, swash,
                 [&](double t, std::vector<BoardOfTest>& boards) { boards[1].shift = t > 30 ? tilt : Eigen::VectorXd(); });
  ASSERT_EQ(run.lines.size(), 1u);
  EXPECT_NE(run.lines[0].find("node b has shifted"), std::string::npos) << run.lines[0];
  EXPECT_GT(run.told_at[0], 30);
  EXPECT_LT(run.told_at[0], 40);
  // Until it is told, what it spoils is not ok; afterwards the surface is that of the others.
  for (const auto& frame : run.kept.frames)
    if (frame.status == proto::FrameStatus::kOk) {
      EXPECT_LT(error_of(frame).norm(), 0.12) << BoardsOfOneSurface::seconds(frame);
    }
  EXPECT_EQ(run.kept.frames.back().corners_used, 400u);
  EXPECT_EQ(run.kept.frames.back().status, proto::FrameStatus::kOk);
}

TEST(Fusion, OfTwoBoardsThatPartNobodyIsBelieved) {
  Eigen::VectorXd tilt(5);
  tilt << 0.2, 1.0, -0.3, 0.1, 0.05;
  const auto run = run_boards({{.name = "a"}, {.name = "b"}}, 50, 7, swash, [&](double t, std::vector<BoardOfTest>& boards) {
    boards[1].shift = t > 25 ? tilt : Eigen::VectorXd();
  });
  ASSERT_EQ(run.lines.size(), 1u);
  EXPECT_LT(run.told_at[0], 35);
  for (const auto& frame : run.kept.frames)
    if (BoardsOfOneSurface::seconds(frame) > 25.1) {
      EXPECT_EQ(frame.status, proto::FrameStatus::kInconsistent);
    }
}

TEST(Fusion, NothingIsToldInAnHourInWhichNothingMoves) {
  const auto run = run_boards({{.name = "a", .hz = 12, .leak = 0.01},
                               {.name = "b", .hz = 12, .phase_s = 0.01, .leak = -0.005},
                               {.name = "c", .hz = 13, .leak = 0.008}},
                              3600, 8, swash, nothing_changes);
  EXPECT_GT(run.kept.frames.size(), 43'000u);
  EXPECT_TRUE(run.lines.empty()) << run.lines.front();
  EXPECT_TRUE(std::all_of(run.kept.frames.begin(), run.kept.frames.end(),
                          [](const auto& frame) { return frame.status == proto::FrameStatus::kOk; }));
}

}  // namespace
}  // namespace srd::host
