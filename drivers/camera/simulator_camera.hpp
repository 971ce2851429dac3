// SPDX-License-Identifier: Apache-2.0
// A scene of the simulator through the camera interface.
#pragma once

#include <cstdint>
#include <memory>

#include "drivers/camera/camera.hpp"
#include "drivers/camera/frame_pool.hpp"
#include "drivers/camera/simulator/renderer.hpp"

namespace srd {

struct SimulatorCameraOptions {
  Pace pace = Pace::kCamera;
  std::uint64_t frames = 0;  // 0: endless
  int buffers = 4;           // at least 3 are reserved, at most FramePool::kMaxBuffers
};

// Renders into its own buffers, in next, on the caller's thread; nothing comes from the heap after start.
// Frame n has sequence n, the time n / rate and the clock kRecording. Never drops: next waits for a free
// buffer. The scene's seed makes the noise.
class SimulatorCamera final : public Camera {
 public:
  explicit SimulatorCamera(Scene scene, const SimulatorCameraOptions& options = {});

  // From frame 0, also when called again. kUsage when the scene cannot be rendered.
  [[nodiscard]] Outcome<void> start() override;
  [[nodiscard]] Capture next(CameraFrame& frame, Nanoseconds timeout) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  void stop() noexcept override { running_ = false; }
  [[nodiscard]] int width() const override { return scene_.width(); }
  [[nodiscard]] int height() const override { return scene_.height(); }
  [[nodiscard]] int buffer_count() const override { return pool_.buffers(); }
  [[nodiscard]] bool live() const override { return false; }
  [[nodiscard]] const Scene& scene() const { return scene_; }

 private:
  Scene scene_;
  SimulatorCameraOptions options_;
  std::unique_ptr<Renderer> renderer_;
  FramePool pool_;
  FramePacer pacer_;
  std::uint64_t next_ = 0;
  bool running_ = false;
};

}  // namespace srd
