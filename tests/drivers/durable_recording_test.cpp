// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/durable_recording.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/camera/recording_camera.hpp"
#include "drivers/recording/image_file.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

constexpr int kWidth = 24, kHeight = 16;

std::vector<std::uint8_t> image_of(std::uint64_t frame) {
  std::vector<std::uint8_t> pixels(kWidth * kHeight);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(frame * 7 + i * 13);
  return pixels;
}

RecordedFrame frame_of(std::uint64_t n) {
  return {{},
          3 * n + 5,
          static_cast<std::int64_t>(20'000'001 * n) + 1'700'000'000'000'000'000,
          1999,
          static_cast<StrobePhase>(n % 3)};
}

int add(DurableRecording& recording, std::uint64_t n) { return recording.add(image_of(n), kWidth, kHeight, frame_of(n)); }

void expect_whole(const Recording& recording, std::uint64_t first = 0) {
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const RecordedFrame& read = recording.frames[i];
    const RecordedFrame written = frame_of(first + i);
    ASSERT_EQ(read.sequence, written.sequence);
    ASSERT_EQ(read.time_ns, written.time_ns);
    ASSERT_EQ(read.exposure_us, written.exposure_us);
    ASSERT_EQ(read.strobe, written.strobe);
    const auto image = read_gray_image(recording.folder / read.file);
    ASSERT_TRUE(image.ok()) << image.error().text();
    ASSERT_EQ(image->pixels, image_of(first + i)) << read.file;
  }
}

// As the kernel does: what a disk could not take is reported once.
int fails_once(int) {
  static bool failed = false;
  if (std::exchange(failed, true)) return 0;
  errno = EIO;
  return -1;
}

TEST(DurableRecording, WhatADiskLostIsNotListedByALaterSync) {
  const fakes::ScratchFolder scratch;
  auto recording = DurableRecording::create(scratch.path() / "rec", false, fails_once);
  ASSERT_TRUE(recording.ok()) << recording.error().text();
  for (std::uint64_t n = 0; n < 3; ++n) ASSERT_EQ(add(*recording, n), 0);
  EXPECT_EQ(recording->sync(), EIO);
  EXPECT_EQ(recording->sync(), EIO);
  EXPECT_EQ(add(*recording, 3), EIO);
  EXPECT_EQ(recording->listed(), 0u);
  EXPECT_EQ(recording->unlisted(), 3u);
  EXPECT_FALSE(read_recording(scratch.path() / "rec").ok());
}

TEST(DurableRecording, ListsOnlyFramesThatAreOnTheDisk) {
  const fakes::ScratchFolder scratch;
  auto recording = DurableRecording::create(scratch.path() / "rec", false);
  ASSERT_TRUE(recording.ok()) << recording.error().text();
  for (std::uint64_t n = 0; n < 3; ++n) ASSERT_EQ(add(*recording, n), 0);
  EXPECT_FALSE(read_recording(scratch.path() / "rec").ok()) << "no frame is on the disk yet";
  ASSERT_EQ(recording->sync(), 0);
  ASSERT_EQ(add(*recording, 3), 0);
  const auto read = read_recording(scratch.path() / "rec");
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(read->frames.size(), 3u);
  EXPECT_EQ(recording->listed(), 3u);
  expect_whole(*read);
}

TEST(DurableRecording, IsNeverReplacedUnasked) {
  const fakes::ScratchFolder scratch;
  const auto folder = scratch.path() / "rec";
  {
    auto first = DurableRecording::create(folder, false);
    ASSERT_TRUE(first.ok());
    ASSERT_EQ(add(*first, 0), 0);
    ASSERT_EQ(first->sync(), 0);
  }
  scratch.write("rec/truth.csv", "frame,time_ns,A00\n0,0,80\n");
  const auto refused = DurableRecording::create(folder, false);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().exit, Exit::kUsage);
  EXPECT_TRUE(read_recording(folder).ok());
  auto forced = DurableRecording::create(folder, true);
  ASSERT_TRUE(forced.ok());
  EXPECT_FALSE(read_recording(folder).ok()) << "images of the old list are not listed any more";
  EXPECT_FALSE(std::filesystem::exists(folder / "truth.csv")) << "of other frames";
}

TEST(DurableRecording, AFrameThatDoesNotFitLeavesTheOthers) {
  const fakes::ScratchFolder scratch;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    auto recording = DurableRecording::create(scratch.path() / "rec", false);
    if (!recording.ok() || add(*recording, 0) != 0 || recording->sync() != 0) ::_exit(1);
    const rlimit limit{kWidth * kHeight / 2, kWidth * kHeight / 2};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    ::_exit(add(*recording, 1) == EFBIG && recording->sync() == 0 && recording->listed() == 1 ? 0 : 2);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "rec/frame_000001.pgm")) << "half an image is left behind";
  const auto read = read_recording(scratch.path() / "rec");
  ASSERT_TRUE(read.ok());
  expect_whole(*read);
}

TEST(DurableRecording, IsReadableAfterItsWriterIsKilled) {
  for (int round = 0; round < 4; ++round) {
    const fakes::ScratchFolder scratch;
    const auto folder = scratch.path() / "rec";
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      auto recording = DurableRecording::create(folder, false);
      for (std::uint64_t n = 0; recording.ok() && n < 1'000'000; ++n) {
        if (add(*recording, n) != 0) ::_exit(1);
        if (n % 7 == 6 && recording->sync() != 0) ::_exit(1);
      }
      ::_exit(2);
    }
    // In the middle of an image, of a row or between them: as it comes.
    std::error_code error;
    while (std::filesystem::file_size(folder / "frames.csv", error) < 900 || error)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::microseconds(700 * round));
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    const auto read = read_recording(folder);
    ASSERT_TRUE(read.ok()) << read.error().text();
    EXPECT_GE(read->frames.size(), 20u);
    expect_whole(*read);
    RecordingCamera camera(folder, {Pace::kMax, {}, 4});
    ASSERT_TRUE(camera.start().ok());
    CameraFrame frame;
    for (std::size_t i = 0; i < read->frames.size(); ++i) {
      ASSERT_EQ(camera.next(frame, std::chrono::seconds(1)), Capture::kFrame);
      camera.give_back(frame);
    }
    EXPECT_EQ(camera.next(frame, std::chrono::seconds(1)), Capture::kEnd);
  }
}

// What a power cut leaves: the list and the last image end anywhere, the list perhaps in bytes that were never written.
TEST(DurableRecording, CutAtAnyByteGivesEveryWholeFrame) {
  const fakes::ScratchFolder scratch;
  const auto folder = scratch.path() / "rec";
  auto recording = DurableRecording::create(folder, false);
  ASSERT_TRUE(recording.ok());
  constexpr std::uint64_t kFrames = 3;
  for (std::uint64_t n = 0; n < kFrames; ++n) ASSERT_EQ(add(*recording, n), 0);
  ASSERT_EQ(recording->sync(), 0);
  const std::string listing = fakes::bytes_of(folder / "frames.csv");
  for (std::size_t cut = 0; cut <= listing.size(); ++cut)
    for (const std::size_t zeros : {0u, 5u}) {
      scratch.write("rec/frames.csv", listing.substr(0, cut) + std::string(zeros, '\0'));
      std::size_t whole = 0;
      for (std::size_t end = listing.find('\n') + 1; end < listing.size(); ++whole) {
        end = listing.find('\n', end) + 1;
        if (cut + (zeros == 0 ? 1 : 0) < end) break;
      }
      const auto read = read_recording(folder);
      ASSERT_EQ(read.ok(), whole > 0) << cut << " " << zeros;
      if (!read.ok()) continue;
      ASSERT_EQ(read->frames.size(), whole) << cut << " " << zeros;
    }
  scratch.write("rec/frames.csv", listing);
  const std::string image = fakes::bytes_of(folder / "frame_000002.pgm");
  for (std::size_t cut = 0; cut <= image.size(); cut += cut < 16 || cut + 4 > image.size() ? 1 : 9) {
    scratch.write("rec/frame_000002.pgm", image.substr(0, cut));
    RecordingCamera camera(folder, {Pace::kMax, {}, 4});
    ASSERT_TRUE(camera.start().ok());
    CameraFrame frame;
    for (std::uint64_t n = 0; n < kFrames; ++n) {
      const bool bad = n == 2 && cut < image.size();
      ASSERT_EQ(camera.next(frame, std::chrono::seconds(1)), bad ? Capture::kBadFrame : Capture::kFrame) << cut;
      camera.give_back(frame);
    }
  }
}

}  // namespace
}  // namespace srd
