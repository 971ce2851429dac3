// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "firmware/health/board_health.hpp"
#include "firmware/health/clock_health.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

using proto::Throttled;

constexpr const char* kFirmware = "sys/devices/platform/soc/soc:firmware/get_throttled";

TEST(BoardHealth, TakesTheProcessorsOwnZone) {
  const fakes::ScratchFolder root;
  root.write("sys/class/thermal/thermal_zone0/type", "acpitz\n");
  root.write("sys/class/thermal/thermal_zone0/temp", "27800\n");
  root.write("sys/class/thermal/thermal_zone1/type", "gpu-thermal\n");
  root.write("sys/class/thermal/thermal_zone1/temp", "40000\n");
  root.write("sys/class/thermal/thermal_zone2/type", "cpu-thermal\n");
  root.write("sys/class/thermal/thermal_zone2/temp", "61350\n");
  root.write("sys/class/thermal/thermal_zone3/type", "soc-thermal\n");
  root.write("sys/class/thermal/thermal_zone3/temp", "no number\n");
  BoardHealth health(root.path());
  EXPECT_EQ(health.thermal_zone(), "cpu-thermal");
  EXPECT_FLOAT_EQ(health.read().temperature_c, 61.35f);
  root.write("sys/class/thermal/thermal_zone2/temp", "-4000\n");
  EXPECT_FLOAT_EQ(health.read().temperature_c, -4);
}

TEST(BoardHealth, AnyZoneIsBetterThanNoneAndNoneIsNotANumber) {
  const fakes::ScratchFolder root;
  EXPECT_TRUE(std::isnan(BoardHealth(root.path()).read().temperature_c));
  EXPECT_FALSE(BoardHealth(root.path()).knows_throttling());
  root.write("sys/class/thermal/thermal_zone0/type", "acpitz\n");
  root.write("sys/class/thermal/thermal_zone0/temp", "27800\n");
  EXPECT_FLOAT_EQ(BoardHealth(root.path()).read().temperature_c, 27.8f);
}

TEST(BoardHealth, ReadsTheBitsOfTheRaspberryPi) {
  const fakes::ScratchFolder root;
  root.write(kFirmware, "50005\n");
  BoardHealth health(root.path());
  EXPECT_TRUE(health.knows_throttling());
  EXPECT_EQ(health.read().throttled, 0x50005u);
  EXPECT_STREQ(proto::throttled_text(health.read().throttled), "under-voltage");
  root.write(kFirmware, "0xffffff08\n");
  EXPECT_EQ(health.read().throttled, 0xF0008u) << "only bits that have a meaning";
  root.write(kFirmware, "\n");
  EXPECT_EQ(health.read().throttled, 0u);
}

TEST(BoardHealth, FindsTheFirmwareOfEveryRaspberryPi) {
  for (const char* bits : {kFirmware, "sys/devices/platform/soc@107c000000/soc@107c000000:firmware/get_throttled"}) {
    const fakes::ScratchFolder root;
    root.write("sys/devices/platform/soc-audio/uevent", "");
    root.write("sys/devices/platform/soc@0/soc@0:power/get_throttled", "f0000\n");
    root.write(bits, "50005\n");
    BoardHealth health(root.path());
    EXPECT_TRUE(health.knows_throttling()) << bits;
    EXPECT_EQ(health.read().throttled, 0x50005u) << bits;
  }
}

TEST(BoardHealth, SeesAnyBoardSlowDownAndRemembersIt) {
  const fakes::ScratchFolder root;
  root.write("sys/class/thermal/cooling_device0/type", "gpio-fan\n");
  root.write("sys/class/thermal/cooling_device0/cur_state", "3\n");
  root.write("sys/class/thermal/cooling_device1/type", "cpufreq-cpu0\n");
  root.write("sys/class/thermal/cooling_device1/cur_state", "0\n");
  root.write("sys/devices/system/cpu/cpufreq/policy0/scaling_max_freq", "1500000\n");
  root.write("sys/devices/system/cpu/cpufreq/policy0/cpuinfo_max_freq", "1500000\n");
  root.write("sys/devices/system/cpu/cpufreq/policy1/scaling_max_freq", "600000\n");  // set so by a person
  root.write("sys/devices/system/cpu/cpufreq/policy1/cpuinfo_max_freq", "1800000\n");
  root.write("sys/class/hwmon/hwmon0/name", "rpi_volt\n");
  root.write("sys/class/hwmon/hwmon0/in0_lcrit_alarm", "0\n");
  BoardHealth health(root.path());
  EXPECT_EQ(health.read().throttled, 0u);
  root.write("sys/class/thermal/cooling_device1/cur_state", "2\n");
  EXPECT_EQ(health.read().throttled, Throttled::kThrottled | Throttled::kThrottled << Throttled::kEverShift);
  root.write("sys/class/thermal/cooling_device1/cur_state", "0\n");
  EXPECT_EQ(health.read().throttled, Throttled::kThrottled << Throttled::kEverShift);
  root.write("sys/devices/system/cpu/cpufreq/policy0/scaling_max_freq", "1200000\n");
  root.write("sys/class/hwmon/hwmon0/in0_lcrit_alarm", "1\n");
  EXPECT_EQ(health.read().throttled & Throttled::kNow, Throttled::kCapped | Throttled::kUnderVoltage);
}

TEST(BoardHealth, TakesNothingFromTheHeapToRead) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  const fakes::ScratchFolder root;
  root.write("sys/class/thermal/thermal_zone0/type", "cpu-thermal\n");
  root.write("sys/class/thermal/thermal_zone0/temp", "61350\n");
  root.write(kFirmware, "0\n");
  BoardHealth health(root.path());
  const fakes::AllocationGauge gauge;
  for (int i = 0; i < 10; ++i) (void)health.read();
  (void)read_clock_health();
  EXPECT_EQ(gauge.count(), 0);
}

TEST(ClockHealth, IsWhatTheKernelSays) {
  timex answer{};
  answer.offset = -250;
  answer.maxerror = 1200;
  answer.status = STA_PLL;
  ClockHealth health = clock_health(TIME_OK, answer);
  EXPECT_EQ(health.state, proto::ClockState::kSynchronised);
  EXPECT_EQ(health.offset_ns, -250'000);
  EXPECT_EQ(health.uncertainty_ns, 1'200'000u);
  answer.status |= STA_NANO;
  EXPECT_EQ(clock_health(TIME_OK, answer).offset_ns, -250);
  answer.status |= STA_UNSYNC;
  health = clock_health(TIME_ERROR, answer);
  EXPECT_EQ(health.state, proto::ClockState::kUnsynchronised);
  EXPECT_FALSE(health.offset_ns.has_value());
  EXPECT_EQ(clock_health(-1, answer).state, proto::ClockState::kUnknown);
  EXPECT_NO_FATAL_FAILURE((void)read_clock_health());
}

}  // namespace
}  // namespace srd::firmware
