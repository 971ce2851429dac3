// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cerrno>
#include <functional>
#include <memory>
#include <vector>

#include "drivers/camera/v4l2/v4l2_camera.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/jpeg_image.hpp"
#include "tests/fakes/scripted_v4l2_port.hpp"

namespace srd {
namespace {

using fakes::ScriptedV4l2Device;
using fakes::ScriptedV4l2Port;
constexpr auto kWait = std::chrono::milliseconds(100);
constexpr std::int64_t kSecond = 1'000'000'000;

V4l2CameraOptions options(const std::string& format = "auto") {
  V4l2CameraOptions made;
  made.ask.path = "/dev/video9";
  made.ask.format = format;
  made.ask.width = 64;
  made.ask.height = 48;
  made.ask.rate_hz = 30;
  return made;
}

std::unique_ptr<V4l2Camera> started(ScriptedV4l2Device& device, const V4l2CameraOptions& with = options()) {
  auto camera = std::make_unique<V4l2Camera>(with, std::make_unique<ScriptedV4l2Port>(device));
  const auto done = camera->start();
  EXPECT_TRUE(done.ok()) << done.error().text();
  return camera;
}

void expect_image(const GrayView& image, std::uint64_t frame) {
  ASSERT_EQ(image.width, 64);
  ASSERT_EQ(image.height, 48);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) ASSERT_EQ(image.row(v)[u], ScriptedV4l2Device::pixel(frame, u, v)) << u << ", " << v;
}

// What a JPEG keeps: a slope.
std::uint8_t smooth(std::uint64_t frame, int u, int v) {
  return static_cast<std::uint8_t>(40 + u + 2 * v + 3 * static_cast<int>(frame));
}

std::vector<std::uint8_t> smooth_jpeg(std::uint64_t frame) {
  std::vector<std::uint8_t> pixels;
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) pixels.push_back(smooth(frame, u, v));
  return fakes::jpeg_of({pixels.data(), 64, 48, 64}, {90, true, false});
}

void expect_smooth(const GrayView& image, std::uint64_t frame) {
  ASSERT_EQ(image.width, 64);
  ASSERT_EQ(image.height, 48);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) ASSERT_NEAR(image.row(v)[u], smooth(frame, u, v), 2) << u << ", " << v;
}

// Calls until the camera gives what is wanted; how many calls it took, 0: never.
int calls_until(V4l2Camera& camera, CameraFrame& frame, Capture wanted, int most = 200) {
  for (int call = 1; call <= most; ++call)
    if (camera.next(frame, kWait) == wanted) return call;
  return 0;
}

TEST(V4l2Camera, GivesEveryFormatAsGrey) {
  for (const V4l2PixelFormat& format : kV4l2Formats)
    for (const int padding : {0, 10})
      for (const bool planes : {false, true}) {
        ScriptedV4l2Device device;
        if (planes) device.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
        const int reduction = format.reduction();
        device.formats = {{format.code, 64 * reduction, 48 * reduction, {30}, padding}};
        for (std::uint64_t n = 0; n < 10 && format.compressed(); ++n) device.jpegs.push_back(smooth_jpeg(n));
        auto camera = started(device);
        for (std::uint64_t n = 0; n < 10; ++n) {
          CameraFrame frame;
          ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame) << format.name;
          EXPECT_EQ(frame.sequence, n);
          EXPECT_EQ(frame.clock, ClockId::kMonotonic);
          if (format.compressed())
            expect_smooth(frame.image, n);
          else
            expect_image(frame.image, n);
          camera->give_back(frame);
        }
      }
}

TEST(V4l2Camera, FramesThatAreHeldAreNotOverwrittenAndTheirLossIsAGap) {
  for (const char* format : {"GREY", "Y10"}) {
    ScriptedV4l2Device device;
    device.formats = {{V4L2_PIX_FMT_GREY}, {V4L2_PIX_FMT_Y10}};
    auto camera = started(device, options(format));
    std::vector<CameraFrame> held(static_cast<std::size_t>(camera->buffer_count()));
    for (CameraFrame& frame : held) ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
    CameraFrame none;
    EXPECT_EQ(camera->next(none, kWait), Capture::kTimeout);
    for (std::size_t i = 0; i < held.size(); ++i) expect_image(held[i].image, i);
    device.now_ns += kSecond;
    for (const CameraFrame& frame : held) camera->give_back(frame);
    ASSERT_EQ(camera->next(none, kWait), Capture::kFrame);
    EXPECT_FALSE(camera->faults().any()) << format << ": " << camera->faults().text();
  }
}

TEST(V4l2Camera, DamagedAndShortFramesAreBadAndCounted) {
  ScriptedV4l2Device device;
  device.damaged = {2, 3};
  device.truncated = {5};
  auto camera = started(device);
  for (std::uint64_t n = 0; n < 8; ++n) {
    CameraFrame frame;
    const bool bad = n == 2 || n == 3 || n == 5;
    ASSERT_EQ(camera->next(frame, kWait), bad ? Capture::kBadFrame : Capture::kFrame) << n;
    EXPECT_EQ(frame.sequence, n);
    EXPECT_GT(frame.time_ns, 0);
    camera->give_back(frame);
  }
  EXPECT_EQ(camera->faults().error_buffers, 3u);
  EXPECT_EQ(camera->faults().text(), "3 error buffers");
}

TEST(V4l2Camera, CompressedFramesThatAreNotWholeAreBadAndCounted) {
  ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_MJPEG}};
  device.jpegs = {smooth_jpeg(0), smooth_jpeg(1), smooth_jpeg(2)};
  device.jpegs[1].resize(device.jpegs[1].size() - 100);
  device.damaged = {3};
  auto camera = started(device);
  EXPECT_NE(camera->summary().find("MJPG at 30 Hz, decoded"), std::string::npos) << camera->summary();
  ASSERT_EQ(camera->image_concerns().size(), 1u);
  EXPECT_NE(camera->image_concerns()[0].find("compressed"), std::string::npos);
  for (std::uint64_t n = 0; n < 30; ++n) {
    CameraFrame frame;
    const bool bad = n == 3 || n % 3 == 1;
    ASSERT_EQ(camera->next(frame, kWait), bad ? Capture::kBadFrame : Capture::kFrame) << n;
    EXPECT_EQ(frame.sequence, n);
    if (!bad) expect_smooth(frame.image, n % 3);
    camera->give_back(frame);
  }
  EXPECT_EQ(camera->faults().error_buffers, 11u);
}

TEST(V4l2Camera, AMosaicIsHalvedByItsGreenPixels) {
  ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_SGRBG10P, 128, 96}};
  auto camera = started(device);
  EXPECT_EQ(camera->width(), 64);
  EXPECT_EQ(camera->height(), 48);
  EXPECT_NE(camera->summary().find("64 x 48 SGRBG10P at 30 Hz, halved by the two green pixels of a cell"), std::string::npos)
      << camera->summary();
}

TEST(V4l2Camera, TakesUpADeviceThatWentAwayAndComesBack) {
  for (const char* format : {"GREY", "Y10"}) {
    ScriptedV4l2Device device;
    device.formats = {{V4L2_PIX_FMT_GREY}, {V4L2_PIX_FMT_Y10}};
    device.gone[5] = 3 * kSecond;
    auto camera = started(device, options(format));
    CameraFrame frame;
    std::int64_t before = 0;
    for (std::uint64_t n = 0; n < 5; ++n) {
      ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
      before = frame.time_ns;
      camera->give_back(frame);
    }
    ASSERT_EQ(camera->next(frame, kWait), Capture::kDisconnected);
    const int calls = calls_until(*camera, frame, Capture::kFrame);
    ASSERT_GT(calls, 3);
    EXPECT_LT(calls, 40) << "waits between tries";
    EXPECT_GT(frame.time_ns - before, 2 * kSecond);
    // As many numbers as periods passed, to the nearest.
    EXPECT_NEAR(static_cast<double>(frame.sequence) - 4, static_cast<double>(frame.time_ns - before) * 30 / kSecond, 0.51);
    expect_image(frame.image, 5);
    EXPECT_EQ(camera->faults().disconnects, 1u);
    EXPECT_EQ(camera->faults().reconnects, 1u);
    camera->stop();
    EXPECT_EQ(camera->last_words(), "");
  }
}

TEST(V4l2Camera, KeepsAHeldImageUntilItIsGivenBackAlthoughTheDeviceIsGone) {
  ScriptedV4l2Device device;
  device.gone[1] = kSecond / 10;
  auto camera = started(device);
  CameraFrame held, frame;
  ASSERT_EQ(camera->next(held, kWait), Capture::kFrame);
  for (int call = 0; call < 200; ++call) ASSERT_EQ(camera->next(frame, kWait), Capture::kDisconnected);
  expect_image(held.image, 0);
  EXPECT_EQ(device.opened, 1) << "not opened again while its memory is in use";
  camera->give_back(held);
  EXPECT_GT(calls_until(*camera, frame, Capture::kFrame), 0);
}

TEST(V4l2Camera, ADeviceThatReturnsWithOtherAbilitiesStaysAwayAndSaysWhyOnce) {
  ScriptedV4l2Device device;
  device.gone[3] = kSecond;
  auto camera = started(device);
  CameraFrame frame;
  for (int n = 0; n < 3; ++n) {
    ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
    camera->give_back(frame);
  }
  device.formats = {{V4L2_PIX_FMT_YUYV, 320, 240}};
  for (int call = 0; call < 50; ++call) ASSERT_EQ(camera->next(frame, kWait), Capture::kDisconnected);
  EXPECT_EQ(camera->faults().disconnects, 1u);
  EXPECT_EQ(camera->faults().reconnects, 0u);
  camera->stop();
  const std::string words = camera->last_words();
  EXPECT_NE(words.find("/dev/video9 went away and did not come back"), std::string::npos) << words;
  EXPECT_NE(words.find("320x240 YUYV instead"), std::string::npos) << words;
}

TEST(V4l2Camera, OpensADeviceThatStandsStillAgain) {
  ScriptedV4l2Device device;
  device.stands_still = {4};
  auto camera = started(device);
  CameraFrame frame;
  for (int n = 0; n < 4; ++n) {
    ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
    camera->give_back(frame);
  }
  const std::int64_t before = device.now_ns;
  EXPECT_GT(calls_until(*camera, frame, Capture::kDisconnected), 1);
  EXPECT_GE(device.now_ns - before, 2 * kSecond);
  EXPECT_EQ(camera->faults().timeouts, 1u);
  EXPECT_GT(calls_until(*camera, frame, Capture::kFrame), 0);
  EXPECT_EQ(camera->faults().reconnects, 1u);
}

TEST(V4l2Camera, ADeviceThatStartsAndFailsAtOnceIsOpenedFiveTimesASecond) {
  ScriptedV4l2Device device;
  auto camera = started(device);
  CameraFrame frame;
  ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
  camera->give_back(frame);
  const int opened = device.opened;
  device.fails_until_ns = device.now_ns + 4 * kSecond;
  ASSERT_GT(calls_until(*camera, frame, Capture::kFrame), 0);
  EXPECT_GE(device.opened - opened, 15);
  EXPECT_LE(device.opened - opened, 22);
  EXPECT_EQ(camera->faults().disconnects, 1u);
  EXPECT_EQ(camera->faults().reconnects, 1u);
}

TEST(V4l2Camera, WaitsForATriggerAsLongAsItTakes) {
  ScriptedV4l2Device device;
  device.stands_still = {0};
  V4l2CameraOptions triggered = options();
  triggered.trigger_input = true;
  auto camera = started(device, triggered);
  CameraFrame frame;
  for (int call = 0; call < 100; ++call) ASSERT_EQ(camera->next(frame, kWait), Capture::kTimeout);
  EXPECT_FALSE(camera->faults().any()) << camera->faults().text();
}

TEST(V4l2Camera, GoesOnPastTheDrivers32Bits) {
  ScriptedV4l2Device device;
  device.first_sequence = 0xffff'fffe;
  auto camera = started(device);
  for (std::uint64_t n = 0xffff'fffe; n < 0x1'0000'0004; ++n) {
    CameraFrame frame;
    ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
    EXPECT_EQ(frame.sequence, n);
    camera->give_back(frame);
  }
}

TEST(V4l2Camera, TimesFramesByWhatTheStampMarks) {
  const auto first = [](std::uint32_t flags, V4l2CameraOptions with) {
    ScriptedV4l2Device device;
    device.buffer_flags = flags;
    with.timing.readout_ns = 8'000'000;
    with.ask.exposure_us = 2000;
    auto camera = started(device, with);
    CameraFrame frame;
    EXPECT_EQ(camera->next(frame, kWait), Capture::kFrame);
    EXPECT_EQ(frame.exposure_us, 2000u);
    return frame.time_ns - device.now_ns / 1000 * 1000;  // stamps are whole us
  };
  V4l2CameraOptions configured = options();
  configured.stamp = StampMark::kFrameStart;
  EXPECT_EQ(first(V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF, options()), -9'000'000);
  EXPECT_EQ(first(V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE, options()), 1'000'000);
  EXPECT_EQ(first(V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF, configured), -1'000'000);
}

TEST(V4l2Camera, SaysWhoseClockTheStampsAre) {
  ScriptedV4l2Device device;
  device.buffer_flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  CameraFrame frame;
  auto unknown = started(device);
  ASSERT_EQ(unknown->next(frame, kWait), Capture::kFrame);
  EXPECT_EQ(frame.clock, ClockId::kUnknown);
  EXPECT_NE(unknown->summary().find("of an unknown clock"), std::string::npos);
  device.stamps = false;
  auto none = started(device);
  ASSERT_EQ(none->next(frame, kWait), Capture::kFrame);
  EXPECT_EQ(frame.clock, ClockId::kMonotonic);
  EXPECT_EQ(frame.time_ns, device.now_ns) << "of its arrival";
}

// Frames of a driver with such stamps, each checked: its time, and whether it was replaced.
void expect_times(const std::function<std::int64_t(std::uint64_t, std::int64_t)>& stamp,
                  const std::function<bool(std::uint64_t)>& replaced, const char* what) {
  ScriptedV4l2Device device;
  device.stamp = stamp;
  auto camera = started(device);
  std::uint64_t count = 0;
  for (std::uint64_t n = 0; n < 90; ++n) {
    CameraFrame frame;
    ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame) << what;
    EXPECT_EQ(frame.clock, ClockId::kMonotonic);
    const std::int64_t said = stamp(n, device.now_ns) / 1000 * 1000;
    EXPECT_EQ(frame.time_ns, replaced(n) ? device.now_ns : said) << what << ", frame " << n;
    count += replaced(n) ? 1 : 0;
    camera->give_back(frame);
  }
  EXPECT_EQ(camera->faults().bad_stamps, count) << what;
  EXPECT_EQ(camera->faults().any(), count > 0);
}

TEST(V4l2Camera, StampsThatCannotBeTrueAreReplacedByTheArrivalAndCounted) {
  const auto none = [](std::uint64_t) { return false; };
  const auto all = [](std::uint64_t) { return true; };
  expect_times([](auto, std::int64_t now) { return now; }, none, "true");
  expect_times([](auto, std::int64_t now) { return now - 120'000'000; }, none, "handed over late");
  expect_times([](std::uint64_t n, std::int64_t now) { return n < 10 ? now : 5'300'000'000; },
               [](std::uint64_t n) { return n >= 10; }, "stands still");
  expect_times([](auto, auto) -> std::int64_t { return 0; }, all, "nothing, said to be monotonic");
  expect_times([](std::uint64_t n, std::int64_t now) { return n < 10 ? now : now - 2 * kSecond; },
               [](std::uint64_t n) { return n >= 10; }, "runs back for good");
  expect_times([](std::uint64_t n, std::int64_t now) { return n == 10 ? now - 100'000'000 : now; },
               [](std::uint64_t n) { return n == 10; }, "runs back once");
  expect_times([](auto, std::int64_t now) { return now - 100 * kSecond; }, all, "negative");
  expect_times([](std::uint64_t n, std::int64_t now) { return n % 3 == 1 ? now + 100'000'000 : now; },
               [](std::uint64_t n) { return n % 3 == 1; }, "in the future");
  expect_times([](auto, std::int64_t now) { return now + 1'000'000; }, none, "the end of a frame, computed ahead of it");
  expect_times([](auto, std::int64_t now) { return now + 1'700'000'000 * kSecond; }, all, "of the wall clock");
}

TEST(V4l2Camera, FramesThatNobodyTookForLongKeepTheirOldStamps) {
  ScriptedV4l2Device device;
  auto camera = started(device);
  CameraFrame frame;
  ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
  camera->give_back(frame);
  std::int64_t before = frame.time_ns;
  device.now_ns += 10 * kSecond;  // the program was stopped; the driver filled its buffers meanwhile
  for (int n = 0; n < 3; ++n) {
    ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
    EXPECT_NEAR(static_cast<double>(frame.time_ns - before), 1e9 / 30, 2000) << n;
    before = frame.time_ns;
    camera->give_back(frame);
  }
  EXPECT_EQ(camera->faults().text(), "");
}

TEST(V4l2Camera, AnArrivalIsTheEndOfTheFrameWhateverTheStampsMark) {
  ScriptedV4l2Device device;
  device.buffer_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  device.stamp = [](std::uint64_t n, std::int64_t now) { return n == 0 ? now - 10'000'000 : 1; };
  V4l2CameraOptions with = options();
  with.timing.readout_ns = 8'000'000;
  with.ask.exposure_us = 2000;
  auto camera = started(device, with);
  CameraFrame frame;
  ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
  EXPECT_NEAR(static_cast<double>(frame.time_ns - device.now_ns), -9e6, 1000) << "stamp at the start, half of 2 ms later";
  camera->give_back(frame);
  ASSERT_EQ(camera->next(frame, kWait), Capture::kFrame);
  EXPECT_EQ(frame.time_ns - device.now_ns, -9'000'000) << "less readout and half the exposure";
  EXPECT_EQ(camera->faults().text(), "1 impossible time stamp");
}

TEST(V4l2Camera, TheStreamAndItsRecoveryTakeNothingFromTheHeap) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "the sanitizer has its own malloc";
  for (const char* format : {"GREY", "YUYV", "MJPG", "SBGGR10P"}) {
    ScriptedV4l2Device device;
    device.formats = {{V4L2_PIX_FMT_GREY}, {V4L2_PIX_FMT_YUYV}, {V4L2_PIX_FMT_MJPEG}, {V4L2_PIX_FMT_SBGGR10P, 128, 96}};
    device.jpegs = {smooth_jpeg(0), smooth_jpeg(1)};
    device.damaged = {10};
    device.gone[20] = kSecond;
    auto camera = started(device, options(format));
    CameraFrame frame;
    const fakes::AllocationGauge gauge;
    for (int n = 0; n < 200; ++n)
      if (camera->next(frame, kWait) == Capture::kFrame) camera->give_back(frame);
    EXPECT_EQ(gauge.count(), 0) << format;
    EXPECT_EQ(camera->faults().error_buffers, 1u);
    EXPECT_EQ(camera->faults().reconnects, 1u);
  }
}

TEST(V4l2Camera, SaysWhenThereIsNoRoomForItsBuffers) {
  ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_GREY}};
  device.most_buffers = 1;
  V4l2Camera camera(options(), std::make_unique<ScriptedV4l2Port>(device));
  const auto done = camera.start();
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().exit, Exit::kDevice);
  EXPECT_NE(done.error().text().find("buffers"), std::string::npos) << done.error().text();
}

}  // namespace
}  // namespace srd
