// SPDX-License-Identifier: Apache-2.0
// Sensor, lock, pulses and labels as one loop in simulated time: images are as bright as the light that fell on them.
#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

#include "firmware/strobe/frame_labels.hpp"
#include "tests/drivers/strobe_bench.hpp"

namespace srd::firmware {
namespace {

constexpr int kSize = 24;

struct LoopSeen {
  int lit = 0, dark = 0, unstrobed = 0;
  int wrong = 0;             // labels that are not the truth, from the 60th frame on
  double worst_time_us = 0;  // of a lit frame against the middle of its light
};

// mark_error_ns: how far the truth of what a stamp marks is from what the configuration says.
LoopSeen run(FrameLabels& labels, const StrobeTiming& timing, const fakes::SimulatedSensor& sensor, double mark_error_ns,
             const fakes::SleepHabits& sleep = {}) {
  StrobeBench bench(timing, sensor, sleep);
  LoopSeen seen;
  std::size_t next = 0, taken = 0;
  std::vector<std::uint8_t> pixels(kSize * kSize);
  const auto label_arrived = [&] {
    for (; taken < bench.pulses.size(); ++taken) labels.add(bench.pulses[taken]);
    const auto& frames = sensor.frames();
    for (; next < frames.size() &&
           static_cast<double>(frames[next].arrival_ns) + mark_error_ns <= static_cast<double>(bench.clock.time_ns());
         ++next) {
      if (!frames[next].delivered) continue;
      const double end = frames[next].truth_ns + static_cast<double>(timing.window_end_ns) + mark_error_ns;
      const double begin = frames[next].truth_ns + static_cast<double>(timing.window_begin_ns) + mark_error_ns;
      double light = 0, middle = 0;
      const auto pulses = bench.line.pulses();
      for (auto pulse = pulses.rbegin(); pulse != pulses.rend() && static_cast<double>(pulse->off_ns) > begin; ++pulse) {
        light += std::max(
            0.0, std::min(end, static_cast<double>(pulse->off_ns)) - std::max(begin, static_cast<double>(pulse->on_ns)));
        middle = static_cast<double>(pulse->on_ns + pulse->off_ns) / 2;
      }
      const double share = light / static_cast<double>(timing.pulse_ns);
      std::fill(pixels.begin(), pixels.end(), static_cast<std::uint8_t>(15 + std::min(150 * share, 200.0)));
      CameraFrame frame;
      frame.image = {pixels.data(), kSize, kSize, kSize};
      frame.time_ns = frames[next].stamp_ns;
      labels.label(frame);
      const bool lit = frame.strobe == StrobePhase::kLit;
      ++(lit ? seen.lit : frame.strobe == StrobePhase::kDark ? seen.dark : seen.unstrobed);
      if (next < 60) continue;
      if (lit != (share > 0.5)) ++seen.wrong;
      if (lit) seen.worst_time_us = std::max(seen.worst_time_us, std::abs(static_cast<double>(frame.time_ns) - middle) / 1e3);
    }
  };
  while (next + 4 < sensor.frames().size()) {
    bench.step();
    label_arrived();
  }
  return seen;
}

fakes::SensorHabits habits() {
  fakes::SensorHabits habits;
  habits.period_ns = 10e6;
  habits.jitter_ns = 10e3;
  habits.drop_share = 0.02;
  habits.delay_ns = 2e6;
  return habits;
}

TEST(StrobeClosedLoop, EveryFrameIsLabelledByTheLightThatMadeIt) {
  for (const char* pattern : {"L", "LD", "LLLD", "LDDLD"}) {
    fakes::SimulatedSensor sensor(21);
    sensor.run(2000, habits());
    StrobeTiming timing = timing_of(10e6);
    timing.pattern = *StrobePattern::parse(pattern);
    FrameLabels labels(timing.pattern, 10, {});
    const LoopSeen seen = run(labels, timing, sensor, 0);
    std::printf("%-6s %d lit, %d dark, %d unstrobed, %d wrong, time to %.2f us\n", pattern, seen.lit, seen.dark, seen.unstrobed,
                seen.wrong, seen.worst_time_us);
    EXPECT_EQ(seen.wrong, 0) << pattern;
    EXPECT_LE(seen.unstrobed, 13) << pattern;  // until it locks
    EXPECT_EQ(labels.counters().mislabelled.load(), 0u) << pattern;
    // The record's times are read within a clock reading of the edges'.
    EXPECT_LE(seen.worst_time_us, 0.5) << pattern;
    const double share = static_cast<double>(timing.pattern.lit_count()) / timing.pattern.length;
    EXPECT_NEAR(static_cast<double>(seen.lit), share * (2000 - 13) * 0.98, 0.03 * 2000) << pattern;
  }
}

TEST(StrobeClosedLoop, APulseThatADelayedThreadLeftOutIsNoLitFrame) {
  fakes::SimulatedSensor sensor(22);
  sensor.run(3000, habits());
  StrobeTiming timing = timing_of(10e6);
  fakes::SleepHabits sleep;
  sleep.delayed_share = 0.03;
  sleep.delayed_ns = 6e6;
  timing.max_duty_ppm = 500'000;
  FrameLabels labels(timing.pattern, 10, {});
  const LoopSeen seen = run(labels, timing, sensor, 0, sleep);
  EXPECT_GT(seen.dark, 20);
  // Light that spilled over the end of an exposure may be in neither or both of two frames.
  EXPECT_LE(seen.wrong, 40);
  EXPECT_GT(seen.lit, 2700);
}

// A profile that takes the stamp for the exposure's start when it is its end: light falls a frame away.
TEST(StrobeClosedLoop, AStampThatMarksSomethingElseIsFoundByTheLight) {
  for (const double error : {10e6, -10e6}) {
    fakes::SimulatedSensor sensor(23);
    fakes::SensorHabits sensor_habits = habits();
    sensor_habits.delay_ns = 12e6;
    sensor.run(600, sensor_habits);
    StrobeTiming timing = timing_of(10e6);
    timing.pattern = *StrobePattern::parse("LLLD");
    FrameLabels labels(timing.pattern, 10, {});
    const LoopSeen seen = run(labels, timing, sensor, error);
    EXPECT_EQ(seen.wrong, 0) << error;
    EXPECT_EQ(labels.shift(), error > 0 ? 1 : -1);
    EXPECT_GE(labels.counters().mislabelled.load(), 1u);  // the first eight frames are judged at once
    EXPECT_EQ(labels.counters().resyncs.load(), 1u);
    EXPECT_LE(seen.worst_time_us, 0.5) << error;
  }
}

}  // namespace
}  // namespace srd::firmware
