// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/estimator/start_history.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {
namespace {

using History = StartHistory<double>;
constexpr std::int64_t kFrame = 20'000'000;  // ns

Coefficients<double> surface(double level) { return fakes::coefficients({level, 0.1 * level, -level}); }

std::vector<double> levels(History& history, std::int64_t time_ns) {
  std::vector<double> out;
  for (const auto& start : history.starts(time_ns)) out.push_back(start[0]);
  return out;
}

TEST(StartHistory, BeginsWithTheGuessAlone) {
  History history(surface(50));
  EXPECT_EQ(levels(history, 0), std::vector<double>{50});
  EXPECT_EQ(history.kind(0), History::Kind::kGuess);
  EXPECT_EQ(history.expected(0)[0], 50);
}

TEST(StartHistory, OffersFourPreviousTheTrendAndTheGuess) {
  History history(surface(50));
  for (int i = 0; i < 6; ++i) history.add(i * kFrame, surface(80 + i * i));
  // 105 = 80 + 25 is newest, 96 before it: one frame on, the line reaches 114.
  EXPECT_EQ(levels(history, 6 * kFrame), (std::vector<double>{105, 96, 89, 84, 114, 50}));
  EXPECT_EQ(history.kind(3), History::Kind::kPrevious);
  EXPECT_EQ(history.kind(4), History::Kind::kTrend);
  EXPECT_EQ(history.kind(5), History::Kind::kGuess);
  EXPECT_EQ(history.expected(6 * kFrame)[0], 114);
}

TEST(StartHistory, DrawsTheTrendInTimeNotInFrames) {
  History history(surface(50));
  history.add(0, surface(80));
  history.add(2 * kFrame, surface(84));  // one frame lost between
  EXPECT_EQ(levels(history, 3 * kFrame), (std::vector<double>{84, 80, 86, 50}));
  EXPECT_EQ(levels(history, 5 * kFrame), (std::vector<double>{84, 80, 90, 50}));  // two more lost
}

TEST(StartHistory, DropsATrendThatWouldLeadTooFar) {
  History history(surface(50));
  history.add(0, surface(80));
  history.add(kFrame, surface(81));
  EXPECT_EQ(levels(history, 5 * kFrame), (std::vector<double>{81, 80, 85, 50}));
  EXPECT_EQ(levels(history, 50 * kFrame), (std::vector<double>{81, 80, 50}));
  EXPECT_EQ(history.expected(50 * kFrame)[0], 81);
}

TEST(StartHistory, ForgetsWhenTimeRunsBack) {
  History history(surface(50));
  history.add(10 * kFrame, surface(80));
  history.add(11 * kFrame, surface(81));
  history.add(2 * kFrame, surface(70));
  EXPECT_EQ(levels(history, 3 * kFrame), (std::vector<double>{70, 50}));
}

TEST(StartHistory, ReplacesASurfaceOfTheSameTime) {
  History history(surface(50));
  history.add(0, surface(80));
  history.add(kFrame, surface(81));
  history.add(kFrame, surface(82));
  EXPECT_EQ(levels(history, 2 * kFrame), (std::vector<double>{82, 80, 84, 50}));
}

TEST(StartHistory, HasNoTrendForATimeThatIsNotAhead) {
  History history(surface(50));
  history.add(0, surface(80));
  history.add(kFrame, surface(81));
  EXPECT_EQ(levels(history, kFrame), (std::vector<double>{81, 80, 50}));
}

TEST(StartHistory, ResetForgetsAndMayChangeTheModel) {
  History history(surface(50));
  history.add(0, surface(80));
  history.reset();
  EXPECT_EQ(levels(history, kFrame), std::vector<double>{50});
  history.reset(fakes::coefficients({60}));
  history.add(kFrame, surface(80));  // of the model before
  EXPECT_EQ(levels(history, 2 * kFrame), std::vector<double>{60});
}

TEST(StartHistory, TakesNoSurfaceThatIsNotFinite) {
  History history(surface(50));
  auto broken = surface(80);
  broken[1] = std::numeric_limits<double>::quiet_NaN();
  history.add(0, broken);
  broken[1] = std::numeric_limits<double>::infinity();
  history.add(kFrame, broken);
  EXPECT_EQ(history.size(), 0);
}

}  // namespace
}  // namespace srd::dsp
