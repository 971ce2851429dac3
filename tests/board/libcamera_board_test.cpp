// SPDX-License-Identifier: Apache-2.0
// The libcamera driver against the kernel's virtual media controller, vimc.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "drivers/camera/libcamera/libcamera_driver.hpp"

namespace srd::board {
namespace {

constexpr auto kLibcameraWait = std::chrono::seconds(2);

class LibcameraBoard : public testing::Test {
 protected:
  void SetUp() override {
    if (!libcamera_is_built()) GTEST_SKIP() << "this build has no libcamera";
    if (list_libcamera_cameras().find("libcamera:") == std::string::npos)
      GTEST_SKIP() << "libcamera knows no camera: start udevd, then modprobe vimc";
  }
  static LibcameraOptions options() {
    LibcameraOptions made;
    made.width = 636;  // what vimc makes of 640
    made.height = 480;
    made.rate_hz = 20;
    made.exposure_us = 2000;
    made.gain = 1;
    return made;
  }
  static std::unique_ptr<Camera> camera_for(const LibcameraOptions& options) {
    auto camera = make_libcamera_camera(options);
    EXPECT_TRUE(camera.ok()) << camera.error().text();
    return camera ? std::move(camera).value() : nullptr;
  }
};

TEST_F(LibcameraBoard, FramesComeInOrderWithIncreasingTimes) {
  const auto camera = camera_for(options());
  const auto started = camera->start();
  ASSERT_TRUE(started.ok()) << started.error().text();
  // vimc has neither control: a note, not a failure.
  EXPECT_NE(camera->summary().find("exposure cannot be set"), std::string::npos) << camera->summary();
  EXPECT_NE(camera->summary().find("gain cannot be set"), std::string::npos) << camera->summary();
  CameraFrame frame;
  std::uint64_t last = 0;
  std::int64_t last_ns = 0;
  for (int n = 0; n < 60; ++n) {
    ASSERT_EQ(camera->next(frame, kLibcameraWait), Capture::kFrame) << n;
    EXPECT_EQ(frame.clock, ClockId::kMonotonic);
    EXPECT_EQ(frame.image.width, 636);
    EXPECT_EQ(frame.image.height, 480);
    if (n > 0) {
      EXPECT_GT(frame.sequence, last);
      EXPECT_GT(frame.time_ns, last_ns);
    }
    last = frame.sequence;
    last_ns = frame.time_ns;
    std::uint8_t low = 255, high = 0;  // vimc's colour bars
    for (int v = 0; v < frame.image.height; ++v) {
      const auto [least, most] = std::minmax_element(frame.image.row(v), frame.image.row(v) + frame.image.width);
      low = std::min(low, *least);
      high = std::max(high, *most);
    }
    EXPECT_GT(high - low, 50);
    camera->give_back(frame);
  }
  EXPECT_FALSE(camera->faults().any()) << camera->faults().text();
  camera->stop();
}

TEST_F(LibcameraBoard, StartsAgainAfterAStop) {
  const auto camera = camera_for(options());
  for (int round = 0; round < 3; ++round) {
    const auto started = camera->start();
    ASSERT_TRUE(started.ok()) << started.error().text();
    CameraFrame frame;
    ASSERT_EQ(camera->next(frame, kLibcameraWait), Capture::kFrame);
    camera->give_back(frame);
    camera->stop();
    EXPECT_EQ(camera->next(frame, kLibcameraWait), Capture::kEnd);
  }
}

TEST_F(LibcameraBoard, SaysWhatIsThere) {
  LibcameraOptions nobody = options();
  nobody.id = "nobody";
  const auto none = camera_for(nobody)->start();
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().exit, Exit::kDevice);
  EXPECT_NE(none.error().text().find("platform/vimc"), std::string::npos) << none.error().text();
  LibcameraOptions odd = options();
  odd.width = 637;
  const auto size = camera_for(odd)->start();
  ASSERT_FALSE(size.ok());
  EXPECT_NE(size.error().text().find("637x480"), std::string::npos) << size.error().text();
  EXPECT_NE(size.error().text().find("RGB888"), std::string::npos) << size.error().text();
}

}  // namespace
}  // namespace srd::board
