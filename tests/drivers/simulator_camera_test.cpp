// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator_camera.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/fakes/allocation_gauge.hpp"

namespace srd {
namespace {

using std::chrono::milliseconds;

SimulatorCameraOptions at_max(std::uint64_t frames = 0) {
  SimulatorCameraOptions options;
  options.pace = Pace::kMax;
  options.frames = frames;
  return options;
}

TEST(SimulatorCamera, GivesTheRenderersFramesAndEnds) {
  SimulatorCamera camera(default_scene(), at_max(3));
  CameraFrame frame;
  EXPECT_EQ(camera.next(frame, milliseconds(1)), Capture::kEnd);  // not started
  ASSERT_TRUE(camera.start());
  EXPECT_FALSE(camera.live());
  auto renderer = Renderer::make(default_scene());
  ASSERT_TRUE(renderer);
  GrayImage expected{std::vector<std::uint8_t>(1280 * 640), 1280, 640};
  for (std::uint64_t i = 0; i < 3; ++i) {
    ASSERT_EQ(camera.next(frame, milliseconds(1)), Capture::kFrame);
    EXPECT_EQ(frame.sequence, i);
    EXPECT_EQ(frame.time_ns, static_cast<std::int64_t>(20'000'000 * i));
    EXPECT_EQ(frame.exposure_us, 2000U);
    renderer->render(i, {expected.pixels.data(), 1280, 640, 1280});
    for (int v = 0; v < 640; v += 37) EXPECT_EQ(std::memcmp(frame.image.row(v), expected.view().row(v), 1280), 0);
    camera.give_back(frame);
  }
  EXPECT_EQ(camera.next(frame, milliseconds(1)), Capture::kEnd);
  ASSERT_TRUE(camera.start());
  ASSERT_EQ(camera.next(frame, milliseconds(1)), Capture::kFrame);
  EXPECT_EQ(frame.sequence, 0U);
  camera.give_back(frame);
  camera.stop();
  EXPECT_EQ(camera.next(frame, milliseconds(1)), Capture::kEnd);
}

TEST(SimulatorCamera, HeldFramesAreLeftAloneAndNothingComesFromTheHeap) {
  SimulatorCamera camera(default_scene(), at_max());
  ASSERT_TRUE(camera.start());
  std::array<CameraFrame, 4> held;
  ASSERT_EQ(camera.buffer_count(), 4);
  const fakes::AllocationGauge gauge;
  for (CameraFrame& frame : held) ASSERT_EQ(camera.next(frame, milliseconds(1)), Capture::kFrame);
  CameraFrame more;
  EXPECT_EQ(camera.next(more, milliseconds(1)), Capture::kTimeout);
  camera.give_back(held[2]);
  EXPECT_EQ(camera.next(more, milliseconds(1)), Capture::kFrame);
  EXPECT_EQ(more.sequence, 4U);
  EXPECT_EQ(more.buffer, held[2].buffer);
  if (fakes::AllocationGauge::works()) {
    EXPECT_EQ(gauge.count(), 0);
  }
}

TEST(SimulatorCamera, SaysWhyItCannotStart) {
  Scene scene = default_scene();
  scene.blur_px = 9;
  EXPECT_FALSE(SimulatorCamera(scene).start());
}

}  // namespace
}  // namespace srd
