// SPDX-License-Identifier: Apache-2.0
// Trigger mode in simulated time: the camera answers each trigger with a frame, or does not.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/drivers/strobe_bench.hpp"

namespace srd {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(WallGrid, HasAMomentAtEachFullSecondForWholeRates) {
  for (const std::int64_t rate : {1, 7, 30, 50, 333, 500}) {
    const WallGrid grid(rate * 1000);
    const std::int64_t second = 1'790'000'000 * kSecond;
    const std::int64_t k = grid.first_from(second);
    EXPECT_EQ(grid.time_ns(k), second) << rate;
    EXPECT_EQ(grid.time_ns(k + rate), second + kSecond) << rate;
    EXPECT_EQ(grid.first_from(second + 1), k + 1) << rate;
    EXPECT_LT(grid.time_ns(k + 1) - second - kSecond / rate, 2);
  }
}

TEST(WallGrid, KeepsAFractionalRateForever) {
  const WallGrid grid(29'970);
  const std::int64_t k = grid.first_from(1'790'000'000 * kSecond + 123);
  EXPECT_GE(grid.time_ns(k), 1'790'000'000 * kSecond + 123);
  EXPECT_LT(grid.time_ns(k - 1), 1'790'000'000 * kSecond + 123);
  EXPECT_EQ(grid.time_ns(k + 2997 * 4) - grid.time_ns(k), 400 * kSecond);
}

// A triggered camera on a board whose wall clock is that far from its monotonic one.
class TriggerBench {
 public:
  explicit TriggerBench(StrobeTiming timing, const fakes::SleepHabits& sleep = {}, bool strobed = true)
      : clock(4, sleep, 5 * kSecond),
        trigger([this] { return clock.time_ns(); }),
        strobe([this] { return clock.time_ns(); }),
        scheduler(timing, strobed ? &strobe : nullptr, &trigger, clock),
        after_(timing.stamp_after_trigger_ns) {
    clock.wall_offset_ns = 1'790'000'000 * kSecond + 123'456'789;
  }
  // answers: whether the camera makes a frame of trigger i.
  template <class Answers>
  void run(std::size_t triggers, Answers answers) {
    while (scheduler.counters().triggers.load() < triggers) {
      const std::size_t before = trigger.pulses().size();
      scheduler.step();
      const auto pulses = trigger.pulses();
      for (std::size_t i = before; i < pulses.size(); ++i)
        if (answers(i)) scheduler.offer({sequence_++, pulses[i].on_ns + after_ + 3000, ClockId::kMonotonic});
    }
    scheduler.step();
  }
  [[nodiscard]] std::int64_t wall_of(std::int64_t monotonic) const { return monotonic + clock.wall_offset_ns; }

  fakes::SimulatedStrobeClock clock;
  fakes::RecordingLine trigger, strobe;
  StrobeScheduler scheduler;

 private:
  std::int64_t after_;
  std::uint64_t sequence_ = 0;
};

// Global shutter; the stamp is the middle of an exposure of 2 ms that begins with the trigger.
StrobeTiming triggered(std::int64_t rate_hz) {
  StrobeTiming timing;
  timing.trigger_rate_mhz = 1000 * rate_hz;
  timing.trigger_pulse_ns = 100'000;
  timing.stamp_after_trigger_ns = 1'000'000;
  timing.window_begin_ns = -1'000'000;
  timing.window_end_ns = 1'000'000;
  timing.pulse_ns = 300'000;
  return timing;
}

TEST(StrobeTrigger, PulsesOnTheGridAndLightsTheExposure) {
  TriggerBench bench(triggered(50));
  bench.run(500, [](std::size_t) { return true; });
  const auto triggers = bench.trigger.pulses(), lights = bench.strobe.pulses();
  ASSERT_EQ(triggers.size(), 500u);
  ASSERT_EQ(lights.size(), 500u);
  std::int64_t last = 0;
  for (std::size_t i = 0; i < triggers.size(); ++i) {
    const std::int64_t wall = bench.wall_of(triggers[i].on_ns), period = kSecond / 50;
    EXPECT_LT(wall % period, 200'000) << i;  // late by sleeping, 10 us on average, never early
    if (i > 0) {
      EXPECT_EQ(wall / period - last, 1) << i;
    }
    last = wall / period;
    EXPECT_GE(lights[i].on_ns, triggers[i].on_ns);
    EXPECT_LE(lights[i].off_ns, triggers[i].on_ns + 2'000'000);
    // In the middle, less half the lateness allowed.
    EXPECT_NEAR(static_cast<double>((lights[i].on_ns + lights[i].off_ns) / 2 - triggers[i].on_ns), 900e3, 150e3);
    EXPECT_NEAR(static_cast<double>(triggers[i].off_ns - triggers[i].on_ns), 100e3, 100e3);
  }
  EXPECT_EQ(bench.scheduler.counters().triggers_missed.load(), 0u);
  EXPECT_EQ(bench.scheduler.counters().untriggered.load(), 0u);
  EXPECT_EQ(bench.scheduler.lateness().count(), 500u);
}

TEST(StrobeTrigger, TwoBoardsExposeTogether) {
  TriggerBench a(triggered(30)), b(triggered(30));
  b.clock.wall_offset_ns += 987'654'321;  // its monotonic clock began at another time
  b.clock.sleep_until(b.clock.time_ns() + 70 * kSecond);
  const auto all = [](std::size_t) { return true; };
  a.run(100, all);
  b.run(100, all);
  const auto grid_error = [](const TriggerBench& bench, const fakes::Pulse& pulse) {
    const WallGrid grid(30'000);
    return bench.wall_of(pulse.on_ns) - grid.time_ns(grid.first_from(bench.wall_of(pulse.on_ns) - 1'000'000));
  };
  for (std::size_t i = 0; i < 100; ++i)
    EXPECT_NEAR(static_cast<double>(grid_error(a, a.trigger.pulses()[i])),
                static_cast<double>(grid_error(b, b.trigger.pulses()[i])), 200e3);
}

TEST(StrobeTrigger, MissedTriggersAndFramesWithoutOneAreCounted) {
  TriggerBench bench(triggered(100), {}, false);
  bench.run(400, [](std::size_t i) { return i % 10 != 3 && i % 100 != 50; });
  EXPECT_EQ(bench.scheduler.counters().triggers_missed.load(), 44u);
  EXPECT_EQ(bench.scheduler.counters().untriggered.load(), 0u);
  EXPECT_TRUE(bench.strobe.edges().empty());
  // A camera that runs freely at twice the rate.
  TriggerWatch watch(4'999'999);
  for (std::int64_t i = 0; i < 100; ++i) {
    watch.triggered(i * 20'000'000);
    watch.stamped(i * 20'000'000 + 100);
    watch.stamped(i * 20'000'000 + 10'000'000);
  }
  EXPECT_EQ(watch.untriggered(), 100u);
  EXPECT_EQ(watch.missed(), 0u);
}

TEST(StrobeTrigger, ADeadCameraMissesEveryTrigger) {
  TriggerBench bench(triggered(100));
  bench.run(1000, [](std::size_t) { return false; });
  EXPECT_GE(bench.scheduler.counters().triggers_missed.load(), 1000u - 64);
}

TEST(StrobeTrigger, AStepOfTheWallClockIsFollowedAndCounted) {
  for (const std::int64_t step : {std::int64_t{7'300'000}, std::int64_t{-7'300'000}, 3600 * kSecond, 5 - 1000 * kSecond}) {
    TriggerBench bench(triggered(50));
    const auto all = [](std::size_t) { return true; };
    bench.run(100, all);
    const std::size_t before = bench.trigger.pulses().size();
    bench.clock.wall_offset_ns += step;
    bench.run(200, all);
    const auto pulses = bench.trigger.pulses();
    EXPECT_EQ(bench.scheduler.counters().wall_steps.load(), 1u) << step;
    for (std::size_t i = before; i < pulses.size(); ++i) {
      EXPECT_LT(bench.wall_of(pulses[i].on_ns) % (kSecond / 50), 200'000) << step << " " << i;
      // Neither two frames in one exposure nor a long gap.
      EXPECT_GT(pulses[i].on_ns - pulses[i - 1].on_ns, 14'900'000) << step << " " << i;
      EXPECT_LT(pulses[i].on_ns - pulses[i - 1].on_ns, 55'200'000) << step << " " << i;
    }
    EXPECT_EQ(bench.scheduler.counters().triggers_missed.load(), 0u);
  }
}

TEST(StrobeTrigger, ASlewedClockIsFollowedWithoutAStep) {
  TriggerBench bench(triggered(50));
  std::int64_t last = bench.clock.time_ns();
  bench.clock.woken = [&](std::int64_t now) {
    bench.clock.wall_offset_ns += (now - last) / 2000;  // 500 ppm, the most that a kernel slews
    last = now;
  };
  bench.run(1000, [](std::size_t) { return true; });
  EXPECT_EQ(bench.scheduler.counters().wall_steps.load(), 0u);
  EXPECT_EQ(bench.scheduler.counters().triggers_missed.load(), 0u);
  const auto pulses = bench.trigger.pulses();
  EXPECT_LT(bench.wall_of(pulses.back().on_ns) % (kSecond / 50), 250'000);
}

TEST(StrobeTrigger, ATriggerThatIsHalfAPeriodLateIsLeftOut) {
  fakes::SleepHabits sleep;
  sleep.delayed_share = 0.05;
  sleep.delayed_ns = 40e6;
  TriggerBench bench(triggered(50), sleep);
  bench.run(500, [](std::size_t) { return true; });
  const auto pulses = bench.trigger.pulses();
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    EXPECT_LT(bench.wall_of(pulses[i].on_ns) % (kSecond / 50), 10'001'000) << i;
    if (i > 0) {
      EXPECT_GT(pulses[i].on_ns - pulses[i - 1].on_ns, 4'900'000) << i;
    }
  }
  EXPECT_GT(bench.scheduler.counters().skipped.load(), 3u);
  EXPECT_GT(bench.scheduler.counters().late.load(), 10u);
}

}  // namespace
}  // namespace srd
