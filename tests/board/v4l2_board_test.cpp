// SPDX-License-Identifier: Apache-2.0
// The V4L2 driver against a real kernel driver: vivid, the virtual video device.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

#include "drivers/camera/v4l2/v4l2_camera.hpp"
#include "tests/board/vivid.hpp"

namespace srd::board {
namespace {

constexpr auto kWait = std::chrono::milliseconds(500);
constexpr int kWebcamWidth = 320, kWebcamHeight = 180;  // vivid's smallest webcam

class V4l2Board : public testing::Test {
 protected:
  void SetUp() override {
    vivid_ = Vivid::find();
    if (!vivid_) GTEST_SKIP() << "no vivid device: modprobe vivid";
    prepare(*vivid_);
  }
  static void prepare(Vivid& vivid) {
    ASSERT_TRUE(vivid.set_input(vivid.input_named("Webcam")));
    ASSERT_TRUE(vivid.choose("OSD Text Mode", "None"));
    ASSERT_TRUE(vivid.choose("Test Pattern", "16x16 Checkers"));
    ASSERT_TRUE(vivid.set("Percentage of Dropped Buffers", 0));
    ASSERT_TRUE(vivid.set("Wrap Sequence Number", 0));
  }
  V4l2CameraOptions options(const std::string& format = "auto") const { return options_of(*vivid_, format); }
  static V4l2CameraOptions options_of(const Vivid& vivid, const std::string& format) {
    V4l2CameraOptions made;
    made.ask.path = vivid.path();
    made.ask.format = format;
    made.ask.width = kWebcamWidth;
    made.ask.height = kWebcamHeight;
    made.ask.rate_hz = 50;
    return made;
  }
  std::optional<Vivid> vivid_;
};

// A frame of a camera, copied.
std::vector<std::uint8_t> one_image(const V4l2CameraOptions& options) {
  V4l2Camera camera(options);
  const auto started = camera.start();
  EXPECT_TRUE(started.ok()) << started.error().text();
  std::vector<std::uint8_t> pixels;
  CameraFrame frame;
  if (!started || camera.next(frame, kWait) != Capture::kFrame) {
    ADD_FAILURE() << "no frame";
    return pixels;
  }
  for (int v = 0; v < frame.image.height; ++v)
    pixels.insert(pixels.end(), frame.image.row(v), frame.image.row(v) + frame.image.width);
  camera.give_back(frame);
  return pixels;
}

TEST_F(V4l2Board, EveryFormatGivesTheSameImage) {
  const auto checkers = one_image(options("GREY"));
  ASSERT_EQ(checkers.size(), static_cast<std::size_t>(kWebcamWidth * kWebcamHeight));
  const bool first = checkers[0] > 127;
  for (int v = 0; v < kWebcamHeight; ++v)
    for (int u = 0; u < kWebcamWidth; ++u)
      ASSERT_EQ(checkers[static_cast<std::size_t>(v * kWebcamWidth + u)] > 127, first != (((u / 16 + v / 16) & 1) != 0))
          << u << ", " << v;

  ASSERT_TRUE(vivid_->choose("Test Pattern", "Gray Ramp"));
  const auto grey = one_image(options("GREY"));
  EXPECT_LT(grey.front() + 200, grey[kWebcamWidth - 1] + 0) << "a ramp from dark to bright";
  for (const char* format : {"Y10", "Y12", "Y16"}) EXPECT_EQ(one_image(options(format)), grey) << format;
  for (const char* format : {"YUYV", "NV12"}) {  // luma from 16 to 235
    const auto luma = one_image(options(format));
    ASSERT_EQ(luma.size(), grey.size());
    double worst = 0;
    for (std::size_t i = 0; i < grey.size(); ++i) worst = std::max(worst, std::abs(luma[i] - (16 + grey[i] * 219.0 / 255)));
    EXPECT_LE(worst, 2) << format;
  }
}

TEST_F(V4l2Board, AMultiPlanarDeviceGivesTheSameImages) {
  auto planar = Vivid::find(V4L2_CAP_VIDEO_CAPTURE_MPLANE);
  if (!planar) GTEST_SKIP() << "no multi-planar vivid device: modprobe vivid n_devs=2 multiplanar=1,2";
  prepare(*planar);
  for (const char* pattern : {"16x16 Checkers", "Gray Ramp"}) {
    ASSERT_TRUE(vivid_->choose("Test Pattern", pattern));
    ASSERT_TRUE(planar->choose("Test Pattern", pattern));
    for (const char* format : {"GREY", "Y10", "Y12", "Y16", "YUYV", "NV12"}) {
      const auto image = one_image(options_of(*planar, format));
      ASSERT_EQ(image.size(), static_cast<std::size_t>(kWebcamWidth * kWebcamHeight));
      EXPECT_EQ(image, one_image(options(format))) << format << ", " << pattern;
    }
  }
}

TEST_F(V4l2Board, FramesComeInOrderAtTheRateAsked) {
  V4l2Camera camera(options());
  ASSERT_TRUE(camera.start().ok());
  EXPECT_NE(camera.summary().find("320 x 180 GREY at 50 Hz, read in place"), std::string::npos) << camera.summary();
  CameraFrame frame;
  std::int64_t first_ns = 0, last_ns = 0;
  std::uint64_t first = 0, last = 0;
  for (int n = 0; n < 60; ++n) {
    ASSERT_EQ(camera.next(frame, kWait), Capture::kFrame);
    EXPECT_EQ(frame.clock, ClockId::kMonotonic);
    if (n == 0) {
      first = frame.sequence;
      first_ns = frame.time_ns;
    } else {
      EXPECT_GT(frame.sequence, last);
      EXPECT_GT(frame.time_ns, last_ns);
    }
    last = frame.sequence;
    last_ns = frame.time_ns;
    camera.give_back(frame);
  }
  // Stamps of the driver's own clock: whole periods apart, however late this machine is.
  EXPECT_NEAR(static_cast<double>(last_ns - first_ns) / static_cast<double>(last - first), 20e6, 1e6);
  EXPECT_FALSE(camera.faults().any()) << camera.faults().text();
}

TEST_F(V4l2Board, SaysWhatItOffers) {
  V4l2CameraOptions odd = options();
  odd.ask.width = 321;
  V4l2Camera wrong_size(odd);
  const auto size = wrong_size.start();
  ASSERT_FALSE(size.ok());
  EXPECT_EQ(size.error().exit, Exit::kDevice);
  for (const char* words : {"321x180", "GREY 320x180 (", "640x360", "Hz", "not usable: "})
    EXPECT_NE(size.error().text().find(words), std::string::npos) << size.error().text();
  V4l2CameraOptions fast = options();
  fast.ask.rate_hz = 5000;
  fast.ask.rate_required = true;
  V4l2Camera wrong_rate(fast);
  const auto rate = wrong_rate.start();
  ASSERT_FALSE(rate.ok());
  EXPECT_NE(rate.error().text().find("5000 Hz"), std::string::npos) << rate.error().text();

  V4l2Camera holder(options());
  ASSERT_TRUE(holder.start().ok());
  V4l2Camera second(options());
  const auto busy = second.start();
  ASSERT_FALSE(busy.ok());
  EXPECT_NE(busy.error().text().find("in use by another program"), std::string::npos) << busy.error().text();
}

TEST_F(V4l2Board, DroppedBuffersAreGapsInTheSequence) {
  V4l2Camera camera(options());
  ASSERT_TRUE(camera.start().ok());
  ASSERT_TRUE(vivid_->set("Percentage of Dropped Buffers", 50));
  CameraFrame frame;
  std::uint64_t first = 0, last = 0;
  constexpr int kFrames = 60;
  for (int n = 0; n < kFrames; ++n) {
    ASSERT_EQ(camera.next(frame, kWait), Capture::kFrame);
    if (n == 0) first = frame.sequence;
    last = frame.sequence;
    camera.give_back(frame);
  }
  EXPECT_GT(last - first, static_cast<std::uint64_t>(kFrames + 10)) << "half of the frames are gone";
}

TEST_F(V4l2Board, AMarkedBufferIsOneBadFrame) {
  V4l2Camera camera(options());
  ASSERT_TRUE(camera.start().ok());
  CameraFrame frame;
  int bad = 0;
  for (int n = 0; n < 40; ++n) {
    if (n == 10 || n == 20) {
      ASSERT_TRUE(vivid_->set("Inject V4L2_BUF_FLAG_ERROR", 1));
    }
    const Capture got = camera.next(frame, kWait);
    ASSERT_TRUE(got == Capture::kFrame || got == Capture::kBadFrame);
    bad += got == Capture::kBadFrame ? 1 : 0;
    camera.give_back(frame);
  }
  EXPECT_EQ(bad, 2);
  EXPECT_EQ(camera.faults().error_buffers, 2u);
  EXPECT_EQ(camera.faults().disconnects, 0u);
}

// Takes frames until the camera lost the device (if it did not before) and has it again; then ten more.
void expect_recovery(V4l2Camera& camera, std::uint64_t last, bool away) {
  CameraFrame frame;
  int after = 0;
  for (int call = 0; call < 400 && after < 10; ++call) {
    const Capture got = camera.next(frame, kWait);
    away = away || got == Capture::kDisconnected;
    if (got != Capture::kFrame) continue;
    EXPECT_GT(frame.sequence, last);
    last = frame.sequence;
    after += away ? 1 : 0;
    camera.give_back(frame);
  }
  EXPECT_EQ(after, 10);
  EXPECT_EQ(camera.faults().disconnects, 1u);
  EXPECT_EQ(camera.faults().reconnects, 1u);
}

TEST_F(V4l2Board, AFatalStreamingErrorIsSurvived) {
  for (const char* format : {"GREY", "Y10"}) {
    V4l2Camera camera(options(format));
    ASSERT_TRUE(camera.start().ok());
    CameraFrame frame;
    ASSERT_EQ(camera.next(frame, kWait), Capture::kFrame);
    camera.give_back(frame);
    ASSERT_TRUE(vivid_->set("Inject Fatal Streaming Error", 1));
    expect_recovery(camera, frame.sequence, false);
  }
}

TEST_F(V4l2Board, ADisconnectIsSurvived) {
  V4l2Camera camera(options());
  ASSERT_TRUE(camera.start().ok());
  CameraFrame held;
  ASSERT_EQ(camera.next(held, kWait), Capture::kFrame);
  ASSERT_TRUE(vivid_->set("Disconnect", 1));
  vivid_->close();  // vivid comes back when nobody holds it open
  CameraFrame frame;
  Capture got = Capture::kFrame;
  for (int call = 0; call < 20 && got != Capture::kDisconnected; ++call) {
    got = camera.next(frame, kWait);
    if (got == Capture::kFrame) camera.give_back(frame);
  }
  ASSERT_EQ(got, Capture::kDisconnected);
  // The image that is still held can be read, and nothing is opened before it is given back.
  int sum = 0;
  for (int v = 0; v < held.image.height; ++v)
    for (int u = 0; u < held.image.width; ++u) sum += held.image.row(v)[u] > 127 ? 1 : 0;
  EXPECT_NEAR(sum, kWebcamWidth * kWebcamHeight / 2, kWebcamWidth * 16);
  EXPECT_EQ(camera.next(frame, kWait), Capture::kDisconnected);
  camera.give_back(held);
  expect_recovery(camera, held.sequence, true);
}

TEST_F(V4l2Board, NumbersGoOnOverTheWrap) {
  ASSERT_TRUE(vivid_->set("Wrap Sequence Number", 1));
  V4l2Camera camera(options());
  ASSERT_TRUE(camera.start().ok());
  CameraFrame frame;
  std::uint64_t last = 0;
  bool below = false, above = false;
  for (int n = 0; n < 300 && !above; ++n) {
    ASSERT_EQ(camera.next(frame, kWait), Capture::kFrame);
    EXPECT_GT(frame.sequence, last);
    if (last != 0) {
      EXPECT_LT(frame.sequence - last, 100u);
    }
    last = frame.sequence;
    below = below || last < 0x1'0000'0000;
    above = below && last >= 0x1'0000'0000;
    camera.give_back(frame);
  }
  EXPECT_TRUE(below);
  EXPECT_TRUE(above);
  ASSERT_TRUE(vivid_->set("Wrap Sequence Number", 0));
}

TEST_F(V4l2Board, AnHdmiInputKeepsTheSizeOfItsTimings) {
  const int hdmi = vivid_->input_named("HDMI");
  ASSERT_GE(hdmi, 0) << "vivid without an HDMI input";
  ASSERT_TRUE(vivid_->set_input(hdmi));
  v4l2_dv_timings timings{};
  ASSERT_EQ(vivid_->port().control(VIDIOC_G_DV_TIMINGS, &timings), 0);
  V4l2CameraOptions right = options("GREY");
  right.ask.width = static_cast<int>(timings.bt.width);
  right.ask.height = static_cast<int>(timings.bt.height);
  right.ask.rate_hz.reset();
  V4l2Camera camera(right);
  const auto started = camera.start();
  ASSERT_TRUE(started.ok()) << started.error().text();
  CameraFrame frame;
  ASSERT_EQ(camera.next(frame, kWait), Capture::kFrame);
  EXPECT_EQ(frame.image.width, right.ask.width);
  camera.give_back(frame);
}

}  // namespace
}  // namespace srd::board
