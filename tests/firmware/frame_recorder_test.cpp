// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/frame_recorder.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>
#include <vector>

#include "firmware/config/instrument.hpp"
#include "firmware/loop/frame_loop.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

constexpr const char* kRecordedNode =
    "[camera]\nsource = \"simulator\"\nrate = \"max\"\n[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = "
    "440\n";

Instrument instrument_of(const std::optional<CameraSource>& source = {}) {
  auto config = NodeConfig::parse(kRecordedNode, "node.toml");
  EXPECT_TRUE(config.ok()) << config.error().text();
  if (source) config->camera = source;
  config->refractive_index = 1.333;
  auto instrument = make_instrument(*config);
  EXPECT_TRUE(instrument.ok()) << instrument.error().text();
  return std::move(instrument).value();
}

std::vector<proto::CoefficientFrame> run(Instrument& instrument, std::uint64_t frames, FrameRecorder* recorder) {
  std::vector<proto::CoefficientFrame> records;
  FrameLoopOptions options{.frames = frames};
  if (recorder != nullptr) options.on_frame = [recorder](const CameraFrame& frame) { recorder->take(frame, true); };
  FrameLoop loop(*instrument.camera, *instrument.tracker, options, [&](const proto::CoefficientFrame& record) {
    records.push_back(record);
    return true;
  });
  std::thread capture([&] { loop.capture(); });
  loop.process();
  capture.join();
  instrument.camera->stop();
  return records;
}

RecordingSection section_of(const std::filesystem::path& folder) {
  RecordingSection section;
  section.folder = folder;
  section.min_free_mib = 0;
  section.sync_ms = 20;
  section.queue_frames = 4;
  return section;
}

// Frames of one small image, without a camera.
struct Frames {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(70 * 30, 9);
  std::uint64_t next = 0;
  CameraFrame frame() {
    CameraFrame out;
    out.image = {pixels.data(), 60, 30, 70};
    out.sequence = next;
    out.time_ns = static_cast<std::int64_t>(next++) * 1000;
    return out;
  }
};

Outcome<std::unique_ptr<FrameRecorder>> start(const RecordingSection& section) {
  static const Instrument instrument = instrument_of();
  return FrameRecorder::start(section, instrument.rig, 60, 30);
}

TEST(FrameRecorder, AReplayGivesTheSameRecordsBitForBit) {
  const fakes::ScratchFolder scratch;
  constexpr std::uint64_t kFrames = 15;
  Instrument live = instrument_of();
  ASSERT_TRUE(live.camera->start().ok());
  auto recorder =
      FrameRecorder::start(section_of(scratch.path() / "rec"), live.rig, live.camera->width(), live.camera->height());
  ASSERT_TRUE(recorder.ok()) << recorder.error().text();
  const auto records = run(live, kFrames, recorder->get());
  (*recorder)->finish();
  EXPECT_EQ((*recorder)->recorded(), kFrames);
  EXPECT_EQ((*recorder)->dropped(), 0u);
  EXPECT_EQ((*recorder)->problem(), "");

  Instrument replay = instrument_of(CameraSource{"recording", (scratch.path() / "rec").string()});
  ASSERT_TRUE(replay.camera->start().ok());
  const auto again = run(replay, 0, nullptr);
  ASSERT_EQ(again.size(), records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const auto &a = records[i], &b = again[i];
    ASSERT_EQ(a.status, proto::FrameStatus::kOk);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.stamp.sensor_time_ns, b.stamp.sensor_time_ns);
    EXPECT_EQ(a.source_sequence, b.source_sequence);
    EXPECT_EQ(a.exposure_us, b.exposure_us);
    EXPECT_EQ(a.strobe, b.strobe);
    EXPECT_EQ(a.corners_used, b.corners_used);
    EXPECT_EQ(a.mean_error, b.mean_error);
    ASSERT_EQ(a.coefficients.size(), b.coefficients.size());
    EXPECT_EQ(std::memcmp(a.coefficients.data(), b.coefficients.data(),
                          sizeof(float) * static_cast<std::size_t>(a.coefficients.size())),
              0);
    EXPECT_EQ(a.information, b.information);
  }
}

TEST(FrameRecorder, ADiskThatIsTooSlowCostsFramesOfTheRecordingOnly) {
  const fakes::ScratchFolder scratch;
  RecordingSection section = section_of(scratch.path() / "rec");
  section.queue_frames = 2;
  auto recorder = start(section);
  ASSERT_TRUE(recorder.ok()) << recorder.error().text();
  Frames frames;
  constexpr std::uint64_t kTaken = 20'000;  // in a fraction of the time that as many files take
  for (std::uint64_t n = 0; n < kTaken; ++n) (*recorder)->take(frames.frame(), false);
  (*recorder)->finish();
  EXPECT_GT((*recorder)->dropped(), 0u);
  EXPECT_EQ((*recorder)->recorded() + (*recorder)->dropped(), kTaken);
  const auto read = read_recording(scratch.path() / "rec");
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(read->frames.size(), (*recorder)->recorded());
}

TEST(FrameRecorder, WhatCannotBeWrittenEndsTheRecordingWithItsReason) {
  const fakes::ScratchFolder scratch;
  auto recorder = start(section_of(scratch.path() / "rec"));
  ASSERT_TRUE(recorder.ok()) << recorder.error().text();
  std::filesystem::remove_all(scratch.path() / "rec");
  Frames frames;
  std::uint64_t taken = 0;
  while (!(*recorder)->stopped()) {
    (*recorder)->take(frames.frame(), true);
    ++taken;
  }
  for (int i = 0; i < 10; ++i, ++taken) (*recorder)->take(frames.frame(), true);  // returns, or this never ends
  (*recorder)->finish();
  EXPECT_EQ((*recorder)->problem(), std::strerror(ENOENT));
  EXPECT_EQ((*recorder)->dropped(), taken);
}

TEST(FrameRecorder, EndsBeforeTheDiskIsFull) {
  const fakes::ScratchFolder scratch;
  RecordingSection section = section_of(scratch.path() / "rec");
  section.min_free_mib = std::uint64_t{1} << 40;
  const auto refused = start(section);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().exit, Exit::kInput);
  EXPECT_FALSE(std::filesystem::exists(section.folder));
}

TEST(FrameRecorder, AQueueBeyondAllMemoryIsRefused) {
  const fakes::ScratchFolder scratch;
  RecordingSection section = section_of(scratch.path() / "rec");
  section.queue_frames = SIZE_MAX / 2000;  // times 60 x 30 it is beyond any address
  const auto refused = start(section);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().exit, Exit::kUsage);
  EXPECT_FALSE(std::filesystem::exists(section.folder));
}

TEST(FrameRecorder, AFrameFromThePastIsNotRecorded) {
  const fakes::ScratchFolder scratch;
  auto recorder = start(section_of(scratch.path() / "rec"));
  ASSERT_TRUE(recorder.ok());
  Frames frames;
  for (int i = 0; i < 3; ++i) (*recorder)->take(frames.frame(), true);
  frames.next = 1;  // a device that came back and counts anew
  (*recorder)->take(frames.frame(), true);
  (*recorder)->finish();
  EXPECT_EQ((*recorder)->recorded(), 3u);
  EXPECT_EQ((*recorder)->dropped(), 1u);
  EXPECT_TRUE(read_recording(scratch.path() / "rec").ok());
}

TEST(FrameRecorder, EachStartOfANodeHasAFolderOfItsOwn) {
  const fakes::ScratchFolder scratch;
  const RecordingSection section = section_of(scratch.path() / "rec");
  std::vector<std::filesystem::path> folders;
  for (int i = 0; i < 3; ++i) {
    auto recorder = start(section);
    ASSERT_TRUE(recorder.ok()) << recorder.error().text();
    folders.push_back((*recorder)->folder());
  }
  EXPECT_EQ(folders,
            (std::vector<std::filesystem::path>{scratch.path() / "rec", scratch.path() / "rec-2", scratch.path() / "rec-3"}));
  RecordingSection exact = section;
  exact.numbered_folders = false;
  EXPECT_FALSE(start(exact).ok());
}

TEST(FrameRecorder, TakesNothingFromTheHeap) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "a sanitizer has its own malloc";
  const fakes::ScratchFolder scratch;
  auto recorder = start(section_of(scratch.path() / "rec"));
  ASSERT_TRUE(recorder.ok());
  Frames frames;
  const fakes::AllocationGauge gauge;
  for (int i = 0; i < 200; ++i) (*recorder)->take(frames.frame(), i % 2 == 0);
  EXPECT_EQ(gauge.count(), 0);
}

}  // namespace
}  // namespace srd::firmware
