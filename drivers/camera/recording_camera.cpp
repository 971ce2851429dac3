// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/recording_camera.hpp"

#include <algorithm>

namespace srd {

RecordingCamera::RecordingCamera(std::filesystem::path folder, const RecordingCameraOptions& options)
    : folder_(std::move(folder)), options_(options) {}

Outcome<void> RecordingCamera::start() {
  Outcome<Recording> recording = read_recording(folder_, options_.times);
  if (!recording) return recording.error();
  recording_ = std::move(recording).value();
  files_.clear();
  for (const RecordedFrame& frame : recording_.frames) files_.push_back((folder_ / frame.file).string());

  Problem first_problem;
  for (const std::string& file : files_) {
    const Outcome<GrayImage> image = read_gray_image(file, options_.sample_bits);
    if (image) {
      bits_advice_ = bits_advice(*image, "camera.bits");
      pool_.reserve(image->width, image->height, std::clamp(options_.buffers, 3, FramePool::kMaxBuffers));
      next_ = 0;
      pacer_.start();
      return {};
    }
    if (first_problem.what.empty()) first_problem = image.error();
  }
  first_problem.advice = "no image of this recording can be read: check the files that frames.csv lists";
  return first_problem;
}

Capture RecordingCamera::next(CameraFrame& frame, Nanoseconds timeout) noexcept {
  if (next_ >= recording_.frames.size()) return Capture::kEnd;
  const RecordedFrame& recorded = recording_.frames[next_];
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  if (options_.pace == Pace::kCamera && !pacer_.wait(recorded.time_ns, timeout)) return Capture::kTimeout;
  const std::optional<std::uint32_t> buffer = pool_.acquire(deadline);
  if (!buffer) return Capture::kTimeout;
  frame = {};
  frame.sequence = recorded.sequence;
  frame.time_ns = recorded.time_ns;
  frame.clock = ClockId::kRecording;
  frame.exposure_us = recorded.exposure_us;
  frame.strobe = recorded.strobe;
  const GrayBuffer target{pool_.pixels(*buffer), pool_.width(), pool_.height(), pool_.stride_bytes()};
  if (!read_gray_image_into(files_[next_++], target, options_.sample_bits)) {
    pool_.release(*buffer);
    return Capture::kBadFrame;
  }
  frame.buffer = *buffer;
  frame.image = pool_.view(*buffer);
  return Capture::kFrame;
}

void RecordingCamera::give_back(const CameraFrame& frame) noexcept {
  if (frame.image.pixels != nullptr) pool_.release(frame.buffer);
}

std::string RecordingCamera::summary() const {
  std::string text;
  for (const std::string& note : recording_.notes) text += "note      " + folder_.string() + ": " + note + "\n";
  if (!bits_advice_.empty()) text += "note      " + folder_.string() + ": " + bits_advice_ + "\n";
  return text;
}

void RecordingCamera::stop() noexcept { next_ = recording_.frames.size(); }

}  // namespace srd
