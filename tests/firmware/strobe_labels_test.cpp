// SPDX-License-Identifier: Apache-2.0
#include "firmware/strobe/frame_labels.hpp"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <random>
#include <string_view>
#include <thread>
#include <vector>

#include "drivers/camera/simulator_camera.hpp"
#include "firmware/config/instrument.hpp"
#include "firmware/loop/frame_loop.hpp"
#include "firmware/strobe/brightness.hpp"
#include "tests/fakes/allocation_gauge.hpp"

namespace srd::firmware {
namespace {

constexpr std::int64_t kLabelledPeriod = 20'000'000;
constexpr int kLabelledSize = 32;

// Exposures with pulses and images; which exposure's light an image shows can be shifted.
class Scene {
 public:
  Scene(std::string_view pattern, int difference, int lit_grey = 120, int dark_grey = 20)
      : pattern_(*StrobePattern::parse(pattern)), labels(pattern_, difference, {}), lit_(lit_grey), dark_(dark_grey) {}

  // Exposure i: its pulse (unless lost), then its frame, whose image shows the light of exposure i + late.
  CameraFrame expose(std::int64_t i, int late = 0, bool with_record = true, StrobePhase skipped = StrobePhase::kLit) {
    if (with_record) {
      StrobePulse pulse;
      pulse.slot = i;
      pulse.stamp_ns = stamp(i);
      pulse.phase = !pattern_.lit(i) ? StrobePhase::kDark : skipped;
      if (pulse.phase == StrobePhase::kLit) {
        pulse.on_ns = stamp(i) + 1'000'000;
        pulse.off_ns = pulse.on_ns + 500'000;
      }
      labels.add(pulse);
    }
    const bool bright = pattern_.lit(i + late) && skipped == StrobePhase::kLit;
    std::normal_distribution<double> noise(0, 3);
    for (std::uint8_t& pixel : pixels_)
      pixel = static_cast<std::uint8_t>(std::clamp((bright ? lit_ : dark_) + noise(random_), 0.0, 255.0));
    CameraFrame frame;
    frame.image = {pixels_.data(), kLabelledSize, kLabelledSize, kLabelledSize};
    frame.sequence = static_cast<std::uint64_t>(i);
    frame.time_ns = stamp(i) + static_cast<std::int64_t>(random_() % 40'000) - 20'000;
    labels.label(frame);
    return frame;
  }
  static std::int64_t stamp(std::int64_t i) { return 1'000'000'000 + i * kLabelledPeriod; }

 private:
  StrobePattern pattern_;

 public:
  FrameLabels labels;

 private:
  int lit_, dark_;
  std::array<std::uint8_t, kLabelledSize * kLabelledSize> pixels_{};
  std::mt19937 random_{3};
};

TEST(StrobeLabels, FollowThePatternAndTakeTheTimeOfThePulse) {
  Scene scene("LLD", 10);
  scene.expose(0);  // one pulse alone does not say how long an exposure is
  for (std::int64_t i = 1; i < 100; ++i) {
    const CameraFrame frame = scene.expose(i);
    EXPECT_EQ(frame.strobe, i % 3 == 2 ? StrobePhase::kDark : StrobePhase::kLit) << i;
    if (i % 3 != 2) {
      EXPECT_EQ(frame.time_ns, Scene::stamp(i) + 1'250'000);
    }
  }
  const LabelCounters& counters = scene.labels.counters();
  EXPECT_EQ(counters.lit.load(), 66u);
  EXPECT_EQ(counters.dark.load(), 33u);
  EXPECT_EQ(counters.mislabelled.load(), 0u);
  EXPECT_NEAR(counters.lit_level.load() / 16.0, 120, 1);
  EXPECT_NEAR(counters.dark_level.load() / 16.0, 20, 1);
}

TEST(StrobeLabels, AnImageThatSaysOtherwiseIsBelievedAndTheShiftIsFound) {
  for (const char* pattern : {"LD", "LLLD", "LLDLD", "LDDDD"}) {
    const int length = static_cast<int>(std::string_view(pattern).size());
    for (int late = -(length - 1); late < length; ++late) {
      Scene scene(pattern, 10);
      const StrobePattern light = *StrobePattern::parse(pattern);
      int wrong_after = 0;
      for (std::int64_t i = 0; i < 200; ++i) {
        const CameraFrame frame = scene.expose(i, late);
        if (i >= 60 && (frame.strobe == StrobePhase::kLit) != light.lit(i + late)) ++wrong_after;
      }
      const auto mislabelled = scene.labels.counters().mislabelled.load();
      EXPECT_EQ(wrong_after, 0) << pattern << " " << late;
      EXPECT_LE(scene.labels.counters().resyncs.load(), 2u) << pattern << " " << late;
      EXPECT_LE(mislabelled, 24u) << pattern << " " << late;
      // Shifts by whole patterns look alike: the nearest is taken.
      EXPECT_EQ((scene.labels.shift() - late) % length, 0) << pattern << " " << late;
      EXPECT_LE(std::abs(scene.labels.shift()), length - 1) << pattern << " " << late;
    }
  }
}

TEST(StrobeLabels, OneFlashInTheDarkIsCountedAndChangesNothing) {
  Scene scene("LD", 10);
  for (std::int64_t i = 0; i < 40; ++i) scene.expose(i);
  EXPECT_EQ(scene.expose(40, 1).strobe, StrobePhase::kDark);  // lit by its pulse, dark to see
  EXPECT_EQ(scene.labels.counters().mislabelled.load(), 1u);
  for (std::int64_t i = 41; i < 80; ++i) EXPECT_EQ(scene.expose(i).strobe, i % 2 == 0 ? StrobePhase::kLit : StrobePhase::kDark);
  EXPECT_EQ(scene.labels.counters().mislabelled.load(), 1u);
  EXPECT_EQ(scene.labels.counters().resyncs.load(), 0u);
}

TEST(StrobeLabels, WithoutEnoughContrastTheRecordsAreBelieved) {
  Scene scene("LD", 10, 100, 95);
  scene.expose(0, 1);
  for (std::int64_t i = 1; i < 60; ++i)
    EXPECT_EQ(scene.expose(i, 1).strobe, i % 2 == 0 ? StrobePhase::kLit : StrobePhase::kDark) << i;
  EXPECT_EQ(scene.labels.counters().mislabelled.load(), 0u);
  EXPECT_EQ(scene.labels.counters().lit_level.load(), 0);
}

TEST(StrobeLabels, ASkippedPulseLeavesADarkFrameOrAnUnstrobedOne) {
  Scene dark("L", 10);
  Scene daylight("L", 10, 120, 115);
  for (std::int64_t i = 0; i < 30; ++i) {
    dark.expose(i);
    daylight.expose(i);
  }
  EXPECT_EQ(dark.expose(30, 0, true, StrobePhase::kUnstrobed).strobe, StrobePhase::kDark);
  const CameraFrame seen = daylight.expose(30, 0, true, StrobePhase::kUnstrobed);
  EXPECT_EQ(seen.strobe, StrobePhase::kUnstrobed);
  EXPECT_NEAR(static_cast<double>(seen.time_ns), static_cast<double>(Scene::stamp(30)), 20'000);
  EXPECT_EQ(dark.labels.counters().unlit.load(), 1u);
}

TEST(StrobeLabels, FramesWithoutARecordAreUnstrobed) {
  Scene scene("LD", 10);
  for (std::int64_t i = 0; i < 10; ++i) EXPECT_EQ(scene.expose(i, 0, false).strobe, StrobePhase::kUnstrobed);
  for (std::int64_t i = 10; i < 40; ++i) scene.expose(i);
  // Two periods after the last pulse.
  EXPECT_EQ(scene.expose(42, 0, false).strobe, StrobePhase::kUnstrobed);
  EXPECT_GE(scene.labels.counters().unlabelled.load(), 11u);
}

TEST(StrobeLabels, APulseLightsOneFrameHoweverFarItsStampIsOff) {
  Scene scene("L", 10);
  scene.expose(0);  // one pulse alone does not tell the period
  for (std::int64_t i = 1; i < 10; ++i) EXPECT_EQ(scene.expose(i).strobe, StrobePhase::kLit);
  CameraFrame late = scene.expose(20, 0, false);  // an image; its stamp is put close to the last frame's
  const auto unlabelled = scene.labels.counters().unlabelled.load();
  late.time_ns = Scene::stamp(9) + kLabelledPeriod / 3;
  scene.labels.label(late);
  EXPECT_EQ(late.strobe, StrobePhase::kUnstrobed);
  EXPECT_EQ(late.time_ns, Scene::stamp(9) + kLabelledPeriod / 3);
  EXPECT_EQ(scene.labels.counters().unlabelled.load(), unlabelled + 1);
}

TEST(StrobeLabels, LabellingTakesNothingFromTheHeap) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  Scene scene("LLDLD", 10);
  const fakes::AllocationGauge gauge;
  for (std::int64_t i = 0; i < 300; ++i) scene.expose(i, i > 150 ? -1 : 0);
  EXPECT_EQ(gauge.count(), 0);
  EXPECT_GT(scene.labels.counters().resyncs.load(), 0u);
}

TEST(StrobeBrightness, IsTheRegionsMean) {
  std::vector<std::uint8_t> pixels(100 * 80, 10);
  for (int v = 20; v < 60; ++v)
    for (int u = 30; u < 90; ++u) pixels[static_cast<std::size_t>(v * 100 + u)] = 200;
  const GrayView image{pixels.data(), 100, 80, 100};
  EXPECT_EQ(mean_brightness_q4(image, {30, 20, 90, 60}), 200 * 16);
  EXPECT_EQ(mean_brightness_q4(image, {0, 0, 30, 80}), 10 * 16);
  // 2400 of 8000 pixels are bright; the grid knows the area to a row and a column of 24.
  EXPECT_NEAR(mean_brightness_q4(image, {}) / 16.0, 10 + 190 * 0.3, 190 * (1.0 / 24 + 1.0 / 24) * 0.6);
}

// Every other frame is dark, as a strobe of the pattern LD says.
class EveryOther final : public FrameLight {
 public:
  void captured(const CameraFrame&) noexcept override { ++frames; }
  void label(CameraFrame& frame) noexcept override {
    frame.strobe = frame.sequence % 2 == 0 ? StrobePhase::kLit : StrobePhase::kDark;
    if (frame.strobe == StrobePhase::kLit) frame.time_ns += 77;
  }
  int frames = 0;
};

TEST(FrameLoop, DarkFramesYieldARecordWithoutProcessing) {
  auto config = NodeConfig::parse("[camera]\nsource = \"simulator\"\n[surface]\nguess_mm = [80]\n", "node.toml");
  ASSERT_TRUE(config.ok());
  config->pace = Pace::kMax;
  auto instrument = make_instrument(*config);
  ASSERT_TRUE(instrument.ok());
  ASSERT_TRUE(instrument->camera->start().ok());
  EveryOther light;
  FrameLoopOptions options;
  options.frames = 8;
  options.light = &light;
  std::vector<proto::CoefficientFrame> records;
  FrameLoop loop(*instrument->camera, *instrument->tracker, options, [&](const proto::CoefficientFrame& record) {
    records.push_back(record);
    return true;
  });
  std::thread capture([&] { loop.capture(); });
  loop.process();
  capture.join();
  ASSERT_EQ(records.size(), 8u);
  EXPECT_EQ(light.frames, 8);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const bool lit = i % 2 == 0;
    EXPECT_EQ(records[i].strobe, lit ? StrobePhase::kLit : StrobePhase::kDark);
    EXPECT_EQ(records[i].status, lit ? proto::FrameStatus::kOk : proto::FrameStatus::kDark);
    EXPECT_EQ(records[i].has_surface(), lit);
    EXPECT_EQ(records[i].stamp.sensor_time_ns, static_cast<std::int64_t>(i) * 20'000'000 + (lit ? 77 : 0));
    EXPECT_EQ(records[i].dropped_before, 0u);
  }
  EXPECT_EQ(loop.counters().dark.load(), 4u);
  EXPECT_EQ(loop.counters().lost_tracks.load(), 0u);
  EXPECT_EQ(loop.counters().acquired.load(), 1u);
}

}  // namespace
}  // namespace srd::firmware
