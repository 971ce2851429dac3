// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator_camera.hpp"

#include <algorithm>

namespace srd {

SimulatorCamera::SimulatorCamera(Scene scene, const SimulatorCameraOptions& options)
    : scene_(std::move(scene)), options_(options) {}

Outcome<void> SimulatorCamera::start() {
  if (!renderer_) {
    Outcome<Renderer> renderer = Renderer::make(scene_);
    if (!renderer) return renderer.error();
    renderer_ = std::make_unique<Renderer>(std::move(renderer).value());
    pool_.reserve(scene_.width(), scene_.height(), std::clamp(options_.buffers, 3, FramePool::kMaxBuffers));
  }
  next_ = 0;
  pacer_.start();
  running_ = true;
  return {};
}

Capture SimulatorCamera::next(CameraFrame& frame, Nanoseconds timeout) noexcept {
  if (!running_ || (options_.frames > 0 && next_ >= options_.frames)) return Capture::kEnd;
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  const std::int64_t time_ns = scene_.time_ns(next_);
  if (options_.pace == Pace::kCamera && !pacer_.wait(time_ns, timeout)) return Capture::kTimeout;
  const std::optional<std::uint32_t> buffer = pool_.acquire(deadline);
  if (!buffer) return Capture::kTimeout;
  frame = {};
  frame.image = pool_.view(*buffer);
  frame.sequence = next_;
  frame.time_ns = time_ns;
  frame.clock = ClockId::kRecording;
  frame.exposure_us = scene_.exposure_us;
  frame.buffer = *buffer;
  renderer_->render(next_++, {pool_.pixels(*buffer), pool_.width(), pool_.height(), pool_.stride_bytes()});
  return Capture::kFrame;
}

void SimulatorCamera::give_back(const CameraFrame& frame) noexcept {
  if (frame.image.pixels != nullptr) pool_.release(frame.buffer);
}

}  // namespace srd
