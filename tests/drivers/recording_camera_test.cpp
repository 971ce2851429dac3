// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/recording_camera.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

using fakes::ScratchFolder;
using std::chrono::milliseconds;

// n frames of 16x8 px, each of one grey level, 1 ms apart.
void record(const std::filesystem::path& folder, int n, ImageFormat format = ImageFormat::kPgm, int width = 16) {
  auto writer = RecordingWriter::create(folder, format, true);
  ASSERT_TRUE(writer) << writer.error().text();
  for (int i = 0; i < n; ++i) {
    const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width * 8), static_cast<std::uint8_t>(i));
    RecordedFrame frame;
    frame.sequence = static_cast<std::uint64_t>(100 + 2 * i);
    frame.time_ns = 1'000'000LL * i;
    frame.exposure_us = 200;
    frame.strobe = StrobePhase::kLit;
    ASSERT_TRUE(writer->add({pixels.data(), width, 8, width}, frame));
  }
}

RecordingCameraOptions at_max() {
  RecordingCameraOptions options;
  options.pace = Pace::kMax;
  return options;
}

// 12 bits at the lower end of 16.
TEST(RecordingCamera, ReadsSamplesByTheirBitsAndTellsWhereTheyLookLikeFewer) {
  const ScratchFolder folder;
  folder.write("a.pgm", std::string("P5\n2 1\n65535\n\x0F\xFF\x08\x01", 17));
  for (const int bits : {0, 12}) {
    RecordingCameraOptions options = at_max();
    options.times.rate_hz = 50;
    options.sample_bits = bits;
    RecordingCamera camera(folder.path(), options);
    ASSERT_TRUE(camera.start());
    EXPECT_EQ(camera.summary().find("camera.bits = 12") != std::string::npos, bits == 0) << camera.summary();
    CameraFrame frame;
    ASSERT_EQ(camera.next(frame, milliseconds(100)), Capture::kFrame);
    EXPECT_EQ(frame.image.row(0)[0], bits == 0 ? 15 : 255);
    EXPECT_EQ(frame.image.row(0)[1], bits == 0 ? 8 : 128);
    camera.give_back(frame);
  }
}

TEST(RecordingCamera, GivesEveryFrameWithItsRow) {
  const ScratchFolder folder;
  record(folder.path(), 6, ImageFormat::kPng);
  RecordingCamera camera(folder.path(), at_max());
  ASSERT_TRUE(camera.start());
  EXPECT_EQ(camera.width(), 16);
  EXPECT_EQ(camera.height(), 8);
  EXPECT_GE(camera.buffer_count(), 3);
  EXPECT_FALSE(camera.live());
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(camera.start());
    CameraFrame frame;
    for (int i = 0; i < 6; ++i) {
      ASSERT_EQ(camera.next(frame, milliseconds(10)), Capture::kFrame);
      EXPECT_EQ(frame.sequence, 100U + 2U * static_cast<unsigned>(i));
      EXPECT_EQ(frame.time_ns, 1'000'000LL * i);
      EXPECT_EQ(frame.clock, ClockId::kRecording);
      EXPECT_EQ(frame.exposure_us, 200U);
      EXPECT_EQ(frame.strobe, StrobePhase::kLit);
      EXPECT_EQ(frame.image.row(7)[15], i);
      camera.give_back(frame);
    }
    EXPECT_EQ(camera.next(frame, milliseconds(10)), Capture::kEnd);
  }
}

TEST(RecordingCamera, BadImagesCostOnlyThemselves) {
  const ScratchFolder folder, other;
  record(folder.path(), 8);
  record(other.path(), 1, ImageFormat::kPgm, 24);
  folder.write("frame_000000.pgm", "P5 16 8 255\ncut");
  std::filesystem::remove(folder.path() / "frame_000003.pgm");
  std::filesystem::copy_file(other.path() / "frame_000000.pgm", folder.path() / "frame_000005.pgm",
                             std::filesystem::copy_options::overwrite_existing);
  RecordingCamera camera(folder.path(), at_max());
  ASSERT_TRUE(camera.start());
  EXPECT_EQ(camera.width(), 16);
  for (int i = 0; i < 8; ++i) {
    CameraFrame frame;
    const bool bad = i == 0 || i == 3 || i == 5;
    EXPECT_EQ(camera.next(frame, milliseconds(10)), bad ? Capture::kBadFrame : Capture::kFrame) << i;
    EXPECT_EQ(frame.sequence, 100U + 2U * static_cast<unsigned>(i));
    EXPECT_EQ(frame.time_ns, 1'000'000LL * i);
    camera.give_back(frame);
  }
}

TEST(RecordingCamera, WaitsForABufferAndDropsNothing) {
  const ScratchFolder folder;
  record(folder.path(), 10);
  RecordingCamera camera(folder.path(), at_max());
  ASSERT_TRUE(camera.start());
  std::vector<CameraFrame> held(static_cast<std::size_t>(camera.buffer_count()));
  for (CameraFrame& frame : held) ASSERT_EQ(camera.next(frame, milliseconds(10)), Capture::kFrame);
  CameraFrame more;
  EXPECT_EQ(camera.next(more, milliseconds(5)), Capture::kTimeout);
  for (std::size_t i = 0; i < held.size(); ++i) EXPECT_EQ(held[i].image.row(0)[0], i);  // untouched while held
  std::thread giver([&] {
    std::this_thread::sleep_for(milliseconds(5));
    camera.give_back(held[1]);
  });
  EXPECT_EQ(camera.next(more, std::chrono::seconds(10)), Capture::kFrame);
  giver.join();
  EXPECT_EQ(more.sequence, 100U + 2U * held.size());
}

TEST(RecordingCamera, KeepsTheRecordedRate) {
  const ScratchFolder folder;
  record(folder.path(), 31);
  RecordingCamera camera(folder.path());
  ASSERT_TRUE(camera.start());
  CameraFrame frame;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 31; ++i) {
    ASSERT_EQ(camera.next(frame, std::chrono::seconds(10)), Capture::kFrame);
    // Never early. How late is the machine's matter.
    EXPECT_GE(std::chrono::steady_clock::now() - start + milliseconds(1), milliseconds(i));
    camera.give_back(frame);
  }
  ASSERT_TRUE(camera.start());
  ASSERT_EQ(camera.next(frame, Nanoseconds(0)), Capture::kFrame);
  EXPECT_EQ(camera.next(frame, Nanoseconds(0)), Capture::kTimeout);
}

TEST(RecordingCamera, SaysWhyItCannotStart) {
  const ScratchFolder folder;
  record(folder.path(), 2);
  for (const char* name : {"frame_000000.pgm", "frame_000001.pgm"}) folder.write(name, "nothing");
  RecordingCamera camera(folder.path());
  const auto started = camera.start();
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().text().find("frame_000000.pgm"), std::string::npos) << started.error().text();
  EXPECT_FALSE(RecordingCamera(folder.path() / "none").start());
}

TEST(RecordingCamera, TakesNothingFromTheHeapForPgm) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "the sanitizer has its own malloc";
  const ScratchFolder folder;
  record(folder.path(), 200);
  RecordingCamera camera(folder.path(), at_max());
  ASSERT_TRUE(camera.start());
  const fakes::AllocationGauge gauge;
  CameraFrame frame;
  while (camera.next(frame, milliseconds(10)) == Capture::kFrame) camera.give_back(frame);
  EXPECT_EQ(gauge.count(), 0);
}

TEST(AllocationGauge, Counts) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "the sanitizer has its own malloc";
  const fakes::AllocationGauge gauge;
  std::vector<int> numbers(100);
  EXPECT_EQ(gauge.count(), 1);
  numbers.resize(1000);
  EXPECT_EQ(gauge.count(), 2);
}

}  // namespace
}  // namespace srd
