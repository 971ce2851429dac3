// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <vector>

#include "dsp/estimate/estimator/start_history.hpp"
#include "tests/dsp/estimator_fixture.hpp"
#include "tests/fakes/allocation_gauge.hpp"

namespace srd::dsp {
namespace {

TEST(AllocationGauge, CountsWhatTheHeapGivesOut) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  const fakes::AllocationGauge counter;
  const auto number = std::make_unique<int>(3);
  EXPECT_GE(counter.count(), 1);
  const std::int64_t before = counter.count();
  void* volatile block = std::malloc(100);
  std::free(block);
  EXPECT_GE(counter.count(), before + 1);
  const std::vector<Vec3<double>> vectors(10);
  EXPECT_GE(counter.count(), before + 2);
  EXPECT_EQ(*number, 3);
}

template <class S>
void expect_no_allocation(Metric metric, Loss loss = Loss::kNone, bool free_index = false) {
  EstimatorOptions options;
  options.metric = metric;
  options.loss = loss;
  options.free_index = free_index;
  options.lower.assign(12, -500);
  options.upper.assign(12, 500);
  Fit<S> fit(fakes::flume_scene(12, 3), options);
  std::mt19937_64 random(1);
  fit.observe(0.1, &random);
  const auto cameras = fit.cameras();
  auto estimator = fit.estimator();
  StartHistory<S> history(fakes::level(12, 85).cast<S>());
  Estimate<S> found;
  std::int64_t count = 0;
  {
    const fakes::AllocationGauge counter;
    for (int frame = 0; frame < 10; ++frame) {
      found = estimator.estimate(cameras, history.starts(frame));
      history.add(frame, found.coefficients);
    }
    // Failures neither.
    const Coefficients<S> far = history.expected(3) * S(100);
    (void)estimator.estimate(cameras, std::span(&far, 1));
    count = counter.count();
  }
  EXPECT_EQ(count, 0) << static_cast<int>(metric);
  EXPECT_FALSE(failed(found.stop));
}

TEST(Estimator, AllocatesNothing) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  for (const Metric metric : kMetrics) {
    expect_no_allocation<float>(metric);
    expect_no_allocation<double>(metric);
    expect_no_allocation<float>(metric, Loss::kTukey);
    expect_no_allocation<float>(metric, Loss::kNone, true);
    expect_no_allocation<double>(metric, Loss::kHuber, true);
  }
}

TEST(Estimator, AllocatesNothingToSayWhatItCannotSeparate) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  Fit<double> fit(fakes::flume_scene(5, 1), {});
  fit.observe();
  fit.scene.model.lx = 1e7;  // A10 is level
  const auto cameras = fit.cameras();
  auto estimator = fit.estimator();
  const Coefficients<double> start = fakes::level(5, 85);
  Estimate<double> found;
  std::int64_t count = 0;
  {
    const fakes::AllocationGauge counter;
    found = estimator.estimate(cameras, std::span(&start, 1));
    count = counter.count();
  }
  EXPECT_EQ(count, 0);
  EXPECT_GT(found.rank.n_dependences, 0);
}

}  // namespace
}  // namespace srd::dsp
