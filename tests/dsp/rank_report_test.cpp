// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/solver/rank_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "tests/dsp/estimator_fixture.hpp"

namespace srd::dsp {
namespace {

std::set<int> others_of(const Dependence& dependence) {
  return {dependence.others.begin(), dependence.others.begin() + dependence.n_others};
}

// Columns of a Jacobian -> information.
InformationMatrix<double> information_of(const std::vector<std::vector<double>>& columns) {
  const auto n = static_cast<Eigen::Index>(columns.size());
  InformationMatrix<double> out = InformationMatrix<double>::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      for (std::size_t k = 0; k < columns[0].size(); ++k)
        out(i, j) += columns[static_cast<std::size_t>(i)][k] * columns[static_cast<std::size_t>(j)][k];
  return out;
}

TEST(RankReport, NamesTheColumnsOfEachCombination) {
  // 2 is 1000 times 0; 4 is 1 + 3; 5 has no effect.
  const std::vector<double> a{1, 2, 0, 1, 0}, b{0, 1, 1, 0, 3}, c{2, 0, 1, 1, 1};
  std::vector<double> a1000 = a, sum = b;
  for (std::size_t i = 0; i < a.size(); ++i) {
    a1000[i] *= 1000;
    sum[i] += c[i];
  }
  RankReport report;
  find_dependences(information_of({a, b, a1000, c, sum, {0, 0, 0, 0, 0}}), 6, report);
  EXPECT_EQ(report.parameters, 6);
  EXPECT_EQ(report.rank, 3);
  EXPECT_TRUE(report.singular());
  ASSERT_EQ(report.n_dependences, 3);
  std::vector<std::set<int>> sets;
  for (int i = 0; i < 3; ++i) {
    std::set<int> set = others_of(report.dependences[static_cast<std::size_t>(i)]);
    set.insert(report.dependences[static_cast<std::size_t>(i)].parameter);
    sets.push_back(set);
  }
  std::sort(sets.begin(), sets.end());
  EXPECT_EQ(sets, (std::vector<std::set<int>>{{0, 2}, {1, 3, 4}, {5}}));
}

TEST(RankReport, TellsNearlyFromExactlyDependent) {
  const std::vector<double> a{1, 2, 0, 1}, b{0, 1, 1, 3};
  std::vector<double> near = a;
  near[2] += 0.01;
  RankReport report;
  find_dependences(information_of({a, b, near}), 3, report);
  EXPECT_EQ(report.rank, 3);
  ASSERT_EQ(report.n_dependences, 1);
  EXPECT_GT(report.dependences[0].pivot, kRankThreshold);
  EXPECT_LT(report.dependences[0].pivot, kNearlyDependent);
}

TEST(RankReport, ExplainsWhatIsNoModeByTheModes) {
  const std::vector<double> a{1, 2, 0, 1}, b{0, 1, 1, 3};
  RankReport report;
  find_dependences(information_of({b, a, a}), 2, report);
  ASSERT_EQ(report.n_dependences, 1);
  EXPECT_EQ(report.dependences[0].parameter, 2);
  EXPECT_EQ(others_of(report.dependences[0]), std::set<int>{1});
}

TEST(RankReport, PivotOfTheLastIsWhatTheOthersLeave) {
  // 1 - R^2 of (1, 1, 0) on (1, 0, 0) and (0, 0, 1) is 1/2.
  const Dependence last = dependence_of_last(information_of({{1, 0, 0}, {0, 0, 2}, {1, 1, 0}}));
  EXPECT_EQ(last.parameter, 2);
  EXPECT_NEAR(last.pivot, 0.5, 1e-12);
  EXPECT_EQ(others_of(last), std::set<int>{0});
}

TEST(EstimatorRank, IsFullForAWholePattern) {
  for (const Metric metric : kMetrics)
    for (const int parameters : {1, 5, 12}) {
      EstimatorOptions options;
      options.metric = metric;
      Fit<double> fit(fakes::flume_scene(parameters, 1), options);
      const auto found = fit.from_flat();
      ASSERT_FALSE(failed(found.stop));
      EXPECT_EQ(found.rank.parameters, parameters);
      EXPECT_EQ(found.rank.rank, parameters);
      EXPECT_EQ(found.rank.n_dependences, 0);
      EXPECT_GE(found.rank.condition, 1);
      EXPECT_LT(found.rank.condition, 1e4);
      if (parameters == 1) {
        EXPECT_NEAR(found.rank.condition, 1, 1e-9);
      }
    }
}

// Of a tank of 4 m, the four corners of one square of 20 mm in its middle.
Estimate<double> of_one_square(int parameters) {
  fakes::Scene scene = fakes::flume_scene(parameters, 1);
  scene.model.lx = scene.model.ly = 4000;
  Fit<double> fit(scene, {});
  fit.observe();
  const auto all = fit.seen[0];
  fit.seen[0] = {all[115], all[116], all[136], all[137]};
  return fit.from_flat();
}

TEST(EstimatorRank, FourCornersOfOneSquareGiveAPlane) {
  // Slopes act at once, through the refraction: a small patch tells them from the level.
  const auto found = of_one_square(3);
  ASSERT_FALSE(failed(found.stop)) << to_string(found.stop);
  EXPECT_EQ(found.rank.rank, 3);
  EXPECT_EQ(found.rank.n_dependences, 0);
}

TEST(EstimatorRank, FourCornersOfOneSquareDoNotTellLongWavesFromThePlane) {
  const auto found = of_one_square(5);
  EXPECT_EQ(found.stop, Stop::kSingular) << to_string(found.stop);
  EXPECT_EQ(found.rank.rank, 3);
  EXPECT_EQ(found.rank.condition, std::numeric_limits<double>::infinity());
  ASSERT_EQ(found.rank.n_dependences, 2);
  // A wave along X is a level and a slope along X there, and none along Y; likewise the other.
  for (const Dependence* d : {&found.rank.dependences[0], &found.rank.dependences[1]}) {
    std::set<int> set = others_of(*d);
    set.insert(d->parameter);
    EXPECT_TRUE(set.contains(3) || set.contains(4));
    EXPECT_GE(set.size(), 2u);
    EXPECT_LE(d->pivot, kRankThreshold);
  }
}

TEST(EstimatorRank, ModesThatCoincideOverTheCornersAreNamed) {
  // Waves along X of some km are level over the pattern: A20 is the constant there, and A22 is A02.
  for (const Metric metric : kMetrics) {
    fakes::Scene scene = fakes::flume_scene(1, 2);
    std::vector<Mode> modes;
    for (const char* name : {"A00", "A01", "A20", "A02", "A22"}) modes.push_back(*Mode::parse(name));
    scene.model.modes = ModeList::make(modes).value();
    scene.truth = fakes::coefficients({80, 1, 0, 0.5, 0});
    EstimatorOptions options;
    options.metric = metric;
    Fit<double> fit(scene, options);
    fit.observe();
    fit.scene.model.lx = 1e7;
    const auto found = fit.from_flat();
    ASSERT_EQ(found.stop, Stop::kSingular) << to_string(found.stop);
    EXPECT_EQ(found.rank.rank, 3);
    ASSERT_EQ(found.rank.n_dependences, 2);
    std::vector<std::set<int>> sets;
    for (int i = 0; i < 2; ++i) {
      const Dependence& d = found.rank.dependences[static_cast<std::size_t>(i)];
      std::set<int> set = others_of(d);
      set.insert(d.parameter);
      sets.push_back(set);
    }
    std::sort(sets.begin(), sets.end());
    EXPECT_EQ(sets, (std::vector<std::set<int>>{{0, 2}, {3, 4}})) << static_cast<int>(metric);
  }
}

}  // namespace
}  // namespace srd::dsp
