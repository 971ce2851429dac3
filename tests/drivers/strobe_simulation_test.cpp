// SPDX-License-Identifier: Apache-2.0
// Sensor, phase lock, scheduler and sleeping thread as one closed loop in simulated time. Figures are printed.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/drivers/strobe_bench.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/simulated_sensor.hpp"

namespace srd {
namespace {

using fakes::SensorHabits;
using fakes::SimulatedSensor;
using fakes::SleepHabits;

SensorHabits habits_of(double rate_hz, double ppm, double jitter_ns, double drops) {
  SensorHabits habits;
  habits.period_ns = 1e9 / rate_hz * (1 + ppm * 1e-6);
  habits.jitter_ns = jitter_ns;
  habits.drop_share = drops;
  habits.delay_ns = 0.3 * habits.period_ns;  // read out and handed over
  return habits;
}

TEST(StrobeSimulation, PulsesFallInTheWindowFromFiveToFiveHundredHertz) {
  std::printf("rate Hz  ppm  jitter us  drops  lit after  phase rms us  theory us  pulses  outside  late  skipped\n");
  struct Case {
    double rate, ppm, jitter_ns, drops;
  };
  for (const Case& c : {Case{5, 100, 20e3, 0},
                        {25, -200, 20e3, 0.02},
                        {50, 50, 1e3, 0},
                        {50, 50, 20e3, 0.1},
                        {120, -80, 10e3, 0.01},
                        {200, 300, 20e3, 0.05},
                        {500, 100, 10e3, 0},
                        {500, -100, 10e3, 0.05}}) {
    constexpr std::size_t kFrames = 4000;
    SimulatedSensor sensor(11);
    const SensorHabits habits = habits_of(c.rate, c.ppm, c.jitter_ns, c.drops);
    sensor.run(kFrames, habits);
    const StrobeTiming timing = timing_of(habits.period_ns);
    StrobeBench bench(timing, sensor, {});
    bench.run();
    const LightSeen all = bench.light(0, kFrames - 2), steady = bench.light(200, kFrames - 2);
    const double rms = bench.phase_rms(200, kFrames);
    const StrobeCounters& counters = bench.scheduler.counters();
    // A pulse in exposure n is planned from stamps up to n - 1, since n - 1 is stamped before n begins. Each frame of a drop
    // looks one frame further ahead: 1 / (1 - drops) on average.
    const double theory = fakes::phase_lock_spread(1 / (1 - c.drops)) * c.jitter_ns;
    std::printf("%7.0f %4.0f %10.1f %6.2f %10zu %13.2f %10.2f %7zu %8zu %5llu %8llu\n", c.rate, c.ppm, c.jitter_ns / 1e3,
                c.drops, bench.frames_to_light(), rms / 1e3, theory / 1e3, all.pulses, all.outside,
                static_cast<unsigned long long>(counters.late.load()),
                static_cast<unsigned long long>(counters.skipped.load()));
    EXPECT_LE(bench.frames_to_light(), 20u);
    // 3800 errors correlated over about 16 frames: their rms is known to 1/sqrt(2 * 240) = 5 %. Three of those; and the next
    // longer look ahead for drops that come together; a stamp is a whole number of ns.
    EXPECT_LE(rms, 1.15 * fakes::phase_lock_spread(1 + 2 * c.drops) / fakes::phase_lock_spread(1) * theory + 2);
    EXPECT_GE(rms, 0.85 * fakes::phase_lock_spread(1) * c.jitter_ns);
    EXPECT_EQ(all.outside, 0u);
    EXPECT_EQ(all.doubles, 0u);
    // Sleeps are 10 us late on average, exponentially: e^-10 of them more than 100 us, and those are skipped at worst.
    EXPECT_GE(steady.lit_frames, kFrames - 202 - counters.skipped.load() - counters.withheld.load() - 1);
    EXPECT_LE(counters.skipped.load(), 3u);
    EXPECT_EQ(counters.overlong.load(), 0u);
    EXPECT_EQ(counters.locks.load(), 1u);
    EXPECT_EQ(bench.scheduler.lateness().count(), counters.pulses.load() + counters.skipped.load() + counters.withheld.load());
  }
}

TEST(StrobeSimulation, HoldoverKeepsPulsesInTheWindowAndEndsBeforeItCannot) {
  constexpr int kLocked = 300;
  SimulatedSensor sensor(3);
  const SensorHabits habits = habits_of(50, 60, 20e3, 0);
  sensor.run(kLocked, habits);
  sensor.lose(3000, habits);
  // One more stamp, so that the bench runs to the end.
  sensor.run(1, habits);
  StrobeTiming timing = timing_of(habits.period_ns);
  timing.window_begin_ns = -1'200'000;
  StrobeBench bench(timing, sensor, {});
  bench.run();
  const LightSeen held = bench.light(kLocked, kLocked + 3000);
  std::printf("held over for %zu frames; phase error in frames 1-100: %.1f us, 400-500: %.1f us\n", held.lit_frames,
              bench.phase_rms(kLocked, kLocked + 100) / 1e3, bench.phase_rms(kLocked + 400, kLocked + 500) / 1e3);
  EXPECT_EQ(held.outside, 0u);
  // It ends when three deviations use up the spare window on one side and half the lateness.
  const double trust = (1.2e6 - 0.6e6) / 2 + 0.05e6;
  const auto deviation = [&](double k) { return fakes::phase_lock_spread(k) * habits.jitter_ns + k * habits.period_ns * 1e-6; };
  double last = 1;
  while (3 * deviation(last) < trust) ++last;
  EXPECT_NEAR(static_cast<double>(held.lit_frames), last, 0.25 * last);  // the jitter is estimated from some 30 stamps
  EXPECT_LE(bench.phase_rms(kLocked, kLocked + 100), 3 * fakes::phase_lock_spread(100) * 20e3);
}

TEST(StrobeSimulation, AfterAStepOfTheRateAtMostAWindowOfFramesIsLitWrongly) {
  for (const double ratio : {0.5, 0.8, 1.25, 2.0}) {
    constexpr int kBefore = 200, kAfter = 200;
    SimulatedSensor sensor(5);
    SensorHabits habits = habits_of(100, 20, 5e3, 0);
    sensor.run(kBefore, habits);
    StrobeTiming timing = timing_of(habits.period_ns, 0.2);
    timing.max_duty_ppm = 200'000;
    habits.period_ns *= ratio;
    sensor.run(kAfter, habits);
    StrobeBench bench(timing, sensor, {});
    bench.run();
    const LightSeen step = bench.light(kBefore, kBefore + 25), after = bench.light(kBefore + 25, kBefore + kAfter - 2);
    std::printf("rate x %.2f: %zu pulses outside in the 25 frames after the step; later %zu of %d frames lit, %zu outside\n",
                1 / ratio, step.outside, after.lit_frames, kAfter - 27, after.outside);
    // Until kMaxRejected stamps tell, and two that are on their way; a sensor that is slower by 2 sees two pulses a frame.
    EXPECT_LE(step.outside, static_cast<std::size_t>((PhaseLock::kMaxRejected + 2) * std::max(ratio, 1.0) + 2)) << ratio;
    EXPECT_EQ(after.outside, 0u) << ratio;
    EXPECT_EQ(after.lit_frames, static_cast<std::size_t>(kAfter - 27)) << ratio;
    EXPECT_GE(bench.scheduler.counters().locks.load(), 2u);
  }
}

TEST(StrobeSimulation, APausedSensorIsFoundAgain) {
  SimulatedSensor sensor(6);
  const SensorHabits habits = habits_of(50, 20, 5e3, 0);
  sensor.run(100, habits);
  sensor.pause(3e9 + 7.7e6);  // not a whole number of periods
  sensor.run(100, habits);
  StrobeTiming timing = timing_of(habits.period_ns);
  timing.window_begin_ns = -1'000'000;
  StrobeBench bench(timing, sensor, {});
  bench.run();
  const LightSeen after = bench.light(120, 198);
  EXPECT_EQ(after.outside, 0u);
  EXPECT_EQ(after.lit_frames, 78u);
  // Records that are not of neighbouring exposures do not look so.
  int apart = 0;
  for (std::size_t i = 1; i < bench.pulses.size(); ++i) {
    const StrobePulse &before = bench.pulses[i - 1], &pulse = bench.pulses[i];
    const bool neighbours = static_cast<double>(pulse.stamp_ns - before.stamp_ns) < 1.5 * habits.period_ns;
    EXPECT_EQ(pulse.slot - before.slot, neighbours ? 1 : 2);
    apart += neighbours ? 0 : 1;
  }
  EXPECT_GE(apart, 1);
}

// Whatever the scheduling: light in any interval t stays below room + max_duty t, and one pulse that ended late.
TEST(StrobeSimulation, ADelayedThreadNeitherDoublesPulsesNorPassesTheDuty) {
  constexpr std::size_t kFrames = 6000;
  SimulatedSensor sensor(8);
  const SensorHabits habits = habits_of(100, 40, 10e3, 0.01);
  sensor.run(kFrames, habits);
  StrobeTiming timing = timing_of(habits.period_ns);
  timing.max_duty_ppm = 60'000;  // pulses of 0.5 ms in 10 ms are 50 000
  SleepHabits sleep;
  sleep.delayed_share = 0.05;
  sleep.delayed_ns = 5e6;
  StrobeBench bench(timing, sensor, sleep);
  bench.run();
  const StrobeCounters& counters = bench.scheduler.counters();
  const LightSeen light = bench.light(0, kFrames - 2);
  std::printf("%zu pulses, %llu late, %llu skipped, %llu withheld, %llu overlong, %llu spilled; %s\n", light.pulses,
              static_cast<unsigned long long>(counters.late.load()), static_cast<unsigned long long>(counters.skipped.load()),
              static_cast<unsigned long long>(counters.withheld.load()),
              static_cast<unsigned long long>(counters.overlong.load()),
              static_cast<unsigned long long>(counters.spilled.load()), bench.scheduler.lateness().text().c_str());
  EXPECT_EQ(light.doubles, 0u);
  // Known of, but for ends that are within the phase error of the window's.
  EXPECT_NEAR(static_cast<double>(light.outside), static_cast<double>(counters.spilled.load()), 3);
  EXPECT_GT(counters.skipped.load(), 20u);
  EXPECT_GT(counters.withheld.load(), 20u);
  EXPECT_GT(light.lit_frames, kFrames * 7 / 10);
  EXPECT_GT(bench.scheduler.lateness().worst_ns(), 3'000'000);

  const auto pulses = bench.line.pulses();
  const double room = static_cast<double>(timing.pulse_ns) * 1.25;
  // Light up to each pulse's start less what may leak: a pulse may begin only within the room.
  double level = 0;
  std::int64_t last = 0, longest = 0;
  for (const auto& pulse : pulses) {
    level = std::max(0.0, level - 0.06 * static_cast<double>(pulse.on_ns - last));
    EXPECT_LE(level + static_cast<double>(timing.pulse_ns), room + 1000) << pulse.on_ns;
    level += static_cast<double>(pulse.off_ns - pulse.on_ns) - 0.06 * static_cast<double>(pulse.off_ns - pulse.on_ns);
    last = pulse.off_ns;
    longest = std::max(longest, pulse.off_ns - pulse.on_ns);
  }
  EXPECT_NEAR(static_cast<double>(longest), static_cast<double>(counters.longest_ns.load()), 1000);
}

TEST(StrobeSimulation, APatternLightsItsExposuresAndRecordsAll) {
  SimulatedSensor sensor(9);
  const SensorHabits habits = habits_of(100, 40, 5e3, 0.02);
  sensor.run(600, habits);
  StrobeTiming timing = timing_of(habits.period_ns);
  timing.pattern = *StrobePattern::parse("LLDLD");
  StrobeBench bench(timing, sensor, {});
  bench.run();
  ASSERT_GT(bench.pulses.size(), 550u);
  const auto pulses = bench.line.pulses();
  std::size_t lit = 0;
  for (std::size_t i = 0; i + 2 < bench.pulses.size(); ++i) {  // the last ones may be of frames that never came
    const StrobePulse& record = bench.pulses[i];
    EXPECT_EQ(record.slot, bench.pulses[0].slot + static_cast<std::int64_t>(i));
    const bool want = std::string_view("LLDLD")[static_cast<std::size_t>(record.slot % 5)] == 'L';
    EXPECT_EQ(record.phase, want ? StrobePhase::kLit : StrobePhase::kDark);
    // The exposure that it names is the one it is about.
    EXPECT_EQ(static_cast<std::size_t>(record.sequence), bench.nearest(static_cast<double>(record.stamp_ns)));
    if (!want) continue;
    ASSERT_LT(lit, pulses.size());
    const fakes::Pulse& pulse = pulses[lit++];
    EXPECT_NEAR(static_cast<double>(record.on_ns), static_cast<double>(pulse.on_ns), 1000);
    EXPECT_NEAR(static_cast<double>(record.off_ns), static_cast<double>(pulse.off_ns), 1000);
    EXPECT_NEAR(static_cast<double>(record.on_ns), static_cast<double>(record.planned_on_ns), 250e3);
  }
  EXPECT_GE(lit + 2, pulses.size());
}

TEST(StrobeSimulation, TheLinesLatencyIsMadeUpFor) {
  SimulatedSensor sensor(9);
  const SensorHabits habits = habits_of(100, 40, 1e3, 0);
  sensor.run(300, habits);
  StrobeTiming timing = timing_of(habits.period_ns);
  timing.window_begin_ns = -700'000;
  timing.delay_ns = 2'000'000;  // longer than the window
  StrobeBench bench(timing, sensor, {});
  bench.run();
  const LightSeen light = bench.light(0, 298);
  EXPECT_EQ(light.outside, 0u);
  EXPECT_GT(light.lit_frames, 280u);
}

TEST(StrobeSimulation, StampsOfAnotherClockComeBackInThatClock) {
  constexpr std::int64_t kSuspended = 12'345'678'901;
  SimulatedSensor sensor(2);
  const SensorHabits habits = habits_of(100, 0, 1e3, 0);
  sensor.run(100, habits);
  fakes::SimulatedStrobeClock clock(1);
  clock.boot_offset_ns = kSuspended;
  fakes::RecordingLine line([&] { return clock.time_ns(); });
  StrobeScheduler scheduler(timing_of(habits.period_ns), &line, nullptr, clock);
  std::size_t given = 0;
  const auto deliver = [&](std::int64_t now) {
    for (; given < 100 && sensor.frames()[given].arrival_ns <= now; ++given)
      scheduler.offer({sensor.frames()[given].sequence, sensor.frames()[given].stamp_ns + kSuspended, ClockId::kBoottime});
  };
  clock.woken = deliver;
  while (given < 100) scheduler.step();
  ASSERT_GT(line.pulses().size(), 70u);
  const StrobePulse record = *scheduler.pulses().front();
  EXPECT_NEAR(static_cast<double>(record.stamp_ns - kSuspended),
              sensor.frames()[static_cast<std::size_t>(record.sequence)].truth_ns, 5e3);
  EXPECT_NEAR(static_cast<double>(record.on_ns - kSuspended), static_cast<double>(line.pulses()[0].on_ns), 1e3);
}

TEST(StrobeSimulation, TheLineIsLowAtStartAtStopAndAtTheEnd) {
  fakes::SimulatedStrobeClock clock(1);
  fakes::RecordingLine line([&] { return clock.time_ns(); });
  line.set(true);
  {
    StrobeScheduler scheduler(timing_of(10e6), &line, nullptr, clock);
    EXPECT_FALSE(line.on());
    line.set(true);
    scheduler.stop();
    scheduler.run();
    EXPECT_FALSE(line.on());
    line.set(true);
  }
  EXPECT_FALSE(line.on());
}

TEST(StrobeSimulation, SteppingTakesNothingFromTheHeap) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  SimulatedSensor sensor(2);
  sensor.run(1000, habits_of(200, 0, 1e3, 0.02));
  StrobeBench bench(timing_of(5e6), sensor, {});
  const fakes::AllocationGauge gauge;
  while (bench.scheduler.counters().pulses.load() < 900) {
    bench.scheduler.step();
    while (bench.scheduler.pulses().front() != nullptr) bench.scheduler.pulses().pop();
  }
  EXPECT_EQ(gauge.count(), 0);
}

}  // namespace
}  // namespace srd
