// SPDX-License-Identifier: Apache-2.0
// Replays a recording through the camera interface. Never drops: next waits for a free buffer.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/camera/camera.hpp"
#include "drivers/camera/frame_pool.hpp"
#include "drivers/recording/recording.hpp"

namespace srd {

struct RecordingCameraOptions {
  Pace pace = Pace::kCamera;
  RecordingTimes times;
  int sample_bits = 0;  // of images with two bytes a sample: as read_gray_image takes it
  int buffers = 4;      // at least 3 are reserved, at most FramePool::kMaxBuffers
};

// Frames have the clock kRecording, and the size of the first image that can be read. An image that is
// missing, cut or of another size gives kBadFrame, and the next call goes on. PGM images are read without the
// heap.
class RecordingCamera final : public Camera {
 public:
  explicit RecordingCamera(std::filesystem::path folder, const RecordingCameraOptions& options = {});

  // From the first frame, also when called again. kInput when no image of the recording can be read.
  [[nodiscard]] Outcome<void> start() override;
  [[nodiscard]] Capture next(CameraFrame& frame, Nanoseconds timeout) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  void stop() noexcept override;
  [[nodiscard]] int width() const override { return pool_.width(); }
  [[nodiscard]] int height() const override { return pool_.height(); }
  [[nodiscard]] int buffer_count() const override { return pool_.buffers(); }
  [[nodiscard]] bool live() const override { return false; }
  // What was read where that is not plain.
  [[nodiscard]] std::string summary() const override;

  // What start read.
  [[nodiscard]] const Recording& recording() const { return recording_; }

 private:
  std::filesystem::path folder_;
  RecordingCameraOptions options_;
  Recording recording_;
  std::vector<std::string> files_;  // whole paths, so that next builds none
  std::string bits_advice_;         // of the first image
  FramePool pool_;
  FramePacer pacer_;
  std::size_t next_ = 0;
};

}  // namespace srd
