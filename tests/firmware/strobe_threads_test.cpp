// SPDX-License-Identifier: Apache-2.0
// The strobe's own thread beside the frame loop's two, in real time: what crosses between them.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <memory>
#include <thread>
#include <vector>

#include "firmware/config/instrument.hpp"
#include "firmware/loop/frame_loop.hpp"
#include "firmware/strobe/strobe.hpp"
#include "tests/fakes/live_camera.hpp"

namespace srd::firmware {
namespace {

constexpr std::int64_t kLoopPeriod = 10'000'000, kExposure = 8'000'000;

class SwitchedLine final : public OutputLine {
 public:
  explicit SwitchedLine(std::atomic<bool>& on) : on_(on) {}
  ~SwitchedLine() override { on_ = false; }
  void set(bool on) noexcept override { on_ = on; }
  [[nodiscard]] std::uint64_t faults() const noexcept override { return 0; }

 private:
  std::atomic<bool>& on_;
};

// Frames at 100 Hz by the monotonic clock, grey throughout; time_ns is the middle of the exposure.
class SteadyCamera final : public fakes::LiveCamera {
 public:
  SteadyCamera(int width, int height) : LiveCamera(width, height), pixels_(static_cast<std::size_t>(width * height), 40) {}
  Outcome<void> start() override {
    first_ns_ = clock_.now_ns() + kLoopPeriod;
    return {};
  }
  Capture next(CameraFrame& frame, Nanoseconds) noexcept override {
    const std::int64_t middle = first_ns_ + static_cast<std::int64_t>(next_) * kLoopPeriod;
    clock_.sleep_until(middle + kExposure / 2 + 1'000'000);
    frame = {};
    frame.image = {pixels_.data(), width(), height(), width()};
    frame.sequence = next_++;
    frame.time_ns = middle;
    frame.clock = ClockId::kMonotonic;
    return Capture::kFrame;
  }

 private:
  SystemStrobeClock clock_;
  std::vector<std::uint8_t> pixels_;
  std::int64_t first_ns_ = 0;
  std::uint64_t next_ = 0;
};

TEST(FrameLoop, AStrobeRunsBesideItAndLabelsItsFrames) {
  constexpr std::uint64_t kFrames = 70;
  auto config = NodeConfig::parse("[camera]\nsource = \"simulator\"\n[surface]\nguess_mm = [80]\n", "node.toml");
  ASSERT_TRUE(config.ok());
  auto instrument = make_instrument(*config);
  ASSERT_TRUE(instrument.ok()) << instrument.error().text();
  SteadyCamera camera(instrument->width, instrument->height);

  StrobeSection section;
  section.mode = StrobeMode::kFollow;
  section.line = "17";
  section.pulse_us = 500;
  section.jitter_us = 5000;  // whatever else this machine does
  section.pattern = *StrobePattern::parse("LD");
  FrameTiming frame;
  frame.exposure_ns = kExposure;
  std::atomic<bool> on{true};
  Strobe strobe(section, strobe_timing(section, frame, 100), {}, std::make_unique<SwitchedLine>(on), nullptr,
                std::make_unique<SystemStrobeClock>());
  EXPECT_FALSE(on.load());
  std::atomic<bool> entered{false};
  strobe.start([&] { entered = true; });

  ASSERT_TRUE(camera.start().ok());
  FrameLoopOptions options;
  options.frames = kFrames;
  options.light = &strobe;
  std::uint64_t dark = 0, lit = 0;
  FrameLoop loop(camera, *instrument->tracker, options, [&](const proto::CoefficientFrame& record) {
    if (record.strobe == StrobePhase::kDark) {
      ++dark;
      EXPECT_EQ(record.status, proto::FrameStatus::kDark);
    }
    if (record.strobe == StrobePhase::kLit) ++lit;
    return true;
  });
  std::thread capture([&] { loop.capture(); });
  loop.process();
  capture.join();
  strobe.stop();
  EXPECT_FALSE(on.load());
  EXPECT_TRUE(entered.load());
  const StrobeReport report = strobe.report();
  EXPECT_EQ(report.locks, 1u);
  EXPECT_GT(report.pulses + report.skipped + report.withheld, 15u);
  EXPECT_GT(report.dark, 15u);
  EXPECT_EQ(loop.counters().dark.load(), dark);
  EXPECT_GT(dark, 0u);
  EXPECT_EQ(strobe.late(), report.late);
  // Images that are all alike cannot tell lit from dark: the records are believed.
  EXPECT_EQ(report.mislabelled, 0u);
  EXPECT_EQ(report.early, 0u);
  for (const char* words : {"strobe    ", " Hz", "pulses    ", "late", "lateness  ", "worst", "mislabelled"})
    EXPECT_NE(report.text().find(words), std::string::npos) << report.text();
  std::printf("%s", report.text().c_str());
}

}  // namespace
}  // namespace srd::firmware
