// SPDX-License-Identifier: Apache-2.0
// GPIO lines and the strobe on a real kernel: gpio-sim's chip stands for the board's.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>

#include "drivers/strobe/gpiod_line.hpp"
#include "drivers/strobe/scheduler.hpp"
#include "tests/board/simulated_chip.hpp"

namespace srd {
namespace {

class GpioBoard : public ::testing::Test {
 protected:
  void SetUp() override {
    if (gpiod_version().empty()) GTEST_SKIP() << "built without libgpiod";
    if (const std::string why = SimulatedChip::missing(); !why.empty()) GTEST_SKIP() << why;
    chip_.emplace("strobe-under-test");
    ASSERT_EQ(chip_->level(), 0);
    std::printf("%s on %s\n", gpiod_version().c_str(), chip_->path().c_str());
  }
  std::optional<SimulatedChip> chip_;
};

TEST_F(GpioBoard, ALineTogglesAndIsLowWhenClosed) {
  auto line = open_gpiod_line({"", "strobe-under-test"}, "test");
  ASSERT_TRUE(line.ok()) << line.error().text();
  EXPECT_EQ(chip_->level(), 0);
  for (int i = 0; i < 5; ++i) {
    (*line)->set(true);
    EXPECT_EQ(chip_->level(), 1);
    (*line)->set(false);
    EXPECT_EQ(chip_->level(), 0);
  }
  (*line)->set(true);
  line->reset();
  EXPECT_EQ(chip_->level(), 0);
}

TEST_F(GpioBoard, AChipIsFoundByPathNameAndLabelAndALineByNameAndNumber) {
  for (const std::string& chip : {chip_->path(), chip_->name(), std::string(SimulatedChip::kLabel)})
    for (const std::string line_name : {"strobe-under-test", "3"}) {
      auto line = open_gpiod_line({chip, line_name}, "test");
      ASSERT_TRUE(line.ok()) << line.error().text();
      (*line)->set(true);
      EXPECT_EQ(chip_->level(), 1) << chip << " " << line_name;
      EXPECT_EQ((*line)->faults(), 0u);
    }
}

TEST_F(GpioBoard, AnActiveLowLineIsOffAtOpenByBeingHigh) {
  auto line = open_gpiod_line({chip_->path(), "3", true}, "test");
  ASSERT_TRUE(line.ok()) << line.error().text();
  EXPECT_EQ(chip_->level(), 1);
  (*line)->set(true);
  EXPECT_EQ(chip_->level(), 0);
}

TEST_F(GpioBoard, ABusyLineNamesWhoHasIt) {
  const auto first = open_gpiod_line({chip_->path(), "3"}, "somebody else");
  ASSERT_TRUE(first.ok());
  const auto second = open_gpiod_line({chip_->path(), "3"}, "test");
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().exit, Exit::kDevice);
  EXPECT_NE(second.error().what.find("in use"), std::string::npos) << second.error().text();
  EXPECT_NE(second.error().found.find("somebody else"), std::string::npos) << second.error().text();
}

TEST_F(GpioBoard, ALineThatIsNotThereListsThoseThatAre) {
  for (const char* name : {"8", "other"}) {
    const auto line = open_gpiod_line({chip_->path(), name}, "test");
    ASSERT_FALSE(line.ok());
    EXPECT_NE(line.error().found.find("lines 0 to 7"), std::string::npos) << line.error().text();
    EXPECT_NE(line.error().found.find("3 \"strobe-under-test\""), std::string::npos) << line.error().text();
  }
  const auto chip = open_gpiod_line({"/dev/gpiochip99", "3"}, "test");
  ASSERT_FALSE(chip.ok());
  EXPECT_NE(chip.error().found.find(chip_->path()), std::string::npos) << chip.error().text();
}

// Other users than root, as on a board: the group that may is named.
TEST_F(GpioBoard, WithoutPermissionTheGroupIsNamed) {
  ASSERT_EQ(::chmod(chip_->path().c_str(), 0660), 0);
  ASSERT_EQ(::chown(chip_->path().c_str(), 0, 60), 0);
  std::fflush(stdout);
  const pid_t child = ::fork();
  if (child == 0) {
    if (::setgid(65534) != 0 || ::setuid(65534) != 0) ::_exit(9);
    for (const LineAddress& address :
         {LineAddress{chip_->path(), "3"}, {SimulatedChip::kLabel, "3"}, {"", "strobe-under-test"}}) {
      const auto line = open_gpiod_line(address, "test");
      if (line.ok()) ::_exit(1);
      std::printf("%s", line.error().text().c_str());
      std::fflush(stdout);
      const bool said = line.error().exit == Exit::kDevice && line.error().what.find("no permission") != std::string::npos &&
                        line.error().found.find("group") != std::string::npos;
      if (!said) ::_exit(2);
      if (line.error().where == chip_->path() && line.error().advice.find("usermod") == std::string::npos) ::_exit(3);
    }
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

// A program that is killed cannot switch off. The kernel gives the line back, and the pull decides: down is the wiring's part.
TEST_F(GpioBoard, AfterAKillThePullDecides) {
  for (const bool up : {false, true}) {
    chip_->pull(up);
    const pid_t child = ::fork();
    if (child == 0) {
      auto line = open_gpiod_line({chip_->path(), "3"}, "test");
      if (line.ok()) (*line)->set(true);
      ::pause();
      ::_exit(0);
    }
    for (int i = 0; i < 500 && chip_->level() != 1; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(chip_->level(), 1);
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    std::printf("after SIGKILL with the line on and a pull-%s: %s\n", up ? "up" : "down", chip_->level() == 1 ? "high" : "low");
    EXPECT_EQ(chip_->level(), up ? 1 : 0);
    // A new start has it low at once.
    const auto line = open_gpiod_line({chip_->path(), "3"}, "test");
    ASSERT_TRUE(line.ok());
    EXPECT_EQ(chip_->level(), 0);
  }
}

// A camera of 25 Hz that exists in its stamps only; the line is watched from outside all the while.
TEST_F(GpioBoard, TheStrobeTogglesTheLineInStepWithACamera) {
  constexpr std::int64_t kPeriod = 40'000'000, kFrames = 120;
  StrobeTiming timing;
  timing.window_begin_ns = -20'000'000;  // an exposure of 20 ms that ends with the stamp
  timing.window_end_ns = 0;
  timing.pulse_ns = 3'000'000;
  timing.jitter_ns = 5'000'000;  // an emulated board is late
  timing.max_pulse_ns = 10'000'000;
  timing.max_duty_ppm = 200'000;
  timing.pattern = *StrobePattern::parse("LLD");
  auto line = open_gpiod_line({chip_->path(), "strobe-under-test"}, "test");
  ASSERT_TRUE(line.ok()) << line.error().text();
  SystemStrobeClock clock;
  StrobeScheduler scheduler(timing, line->get(), nullptr, clock);

  std::atomic<bool> done{false};
  std::atomic<int> rises{0};
  std::thread watch([&] {
    for (int before = 0; !done.load(); std::this_thread::sleep_for(std::chrono::microseconds(300))) {
      const int level = chip_->level();
      if (level == 1 && before == 0) ++rises;
      before = level;
    }
  });
  std::thread strobe([&] {
    sched_param priority{};
    priority.sched_priority = 60;
    if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0) std::printf("without a real-time priority\n");
    scheduler.run();
  });
  const std::int64_t first = clock.now_ns() + kPeriod;
  for (std::int64_t i = 0; i < kFrames; ++i) {
    clock.sleep_until(first + i * kPeriod + 5'000'000);  // read out
    if (i % 20 != 13) scheduler.offer({static_cast<std::uint64_t>(i), first + i * kPeriod, ClockId::kMonotonic});
  }
  scheduler.stop();
  strobe.join();
  done = true;
  watch.join();

  const StrobeCounters& counters = scheduler.counters();
  std::printf("%llu pulses, %d seen on the line, %llu late, %llu skipped, %llu withheld; phase to %.1f us\nlateness %s\n",
              static_cast<unsigned long long>(counters.pulses.load()), rises.load(),
              static_cast<unsigned long long>(counters.late.load()), static_cast<unsigned long long>(counters.skipped.load()),
              static_cast<unsigned long long>(counters.withheld.load()),
              static_cast<double>(counters.uncertainty_ns.load()) / 1e3, scheduler.lateness().text().c_str());
  EXPECT_EQ(chip_->level(), 0);
  EXPECT_EQ((*line)->faults(), 0u);
  EXPECT_EQ(counters.lock.load(), LockState::kLocked);
  EXPECT_EQ(counters.locks.load(), 1u);
  // 10 frames to lock, two of three lit.
  EXPECT_GE(counters.pulses.load() + counters.skipped.load() + counters.withheld.load(), 60u);
  EXPECT_GE(counters.pulses.load(), 30u);
  EXPECT_LE(rises.load(), static_cast<int>(counters.pulses.load()));
  EXPECT_GE(rises.load(), static_cast<int>(counters.pulses.load()) / 2);
  while (const StrobePulse* record = scheduler.pulses().front()) {
    if (record->phase == StrobePhase::kLit) {
      const std::int64_t exposure = first + static_cast<std::int64_t>(record->sequence) * kPeriod;
      EXPECT_GE(record->on_ns, exposure - 20'000'000);
      EXPECT_LE(record->on_ns + timing.pulse_ns, exposure + 100'000);
    }
    scheduler.pulses().pop();
  }
}

}  // namespace
}  // namespace srd
