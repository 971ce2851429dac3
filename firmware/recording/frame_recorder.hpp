// SPDX-License-Identifier: Apache-2.0
// Keeps the camera's frames on disk while the node measures: copied into a queue that is reserved once, written by a thread
// of its own. A disk that is too slow costs frames of the recording, one that is full ends it; the measurement never waits.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "drivers/camera/camera.hpp"
#include "drivers/recording/durable_recording.hpp"
#include "dsp/core/spsc_ring.hpp"
#include "firmware/recording/recorded_rig.hpp"
#include "firmware/recording/recording_section.hpp"

namespace srd::firmware {

class FrameRecorder {
 public:
  // Makes the folder, reserves the queue for images of width x height, starts the thread. kUsage when the folder holds a
  // recording or the memory no queue, kInput when it cannot be written or has too little room.
  [[nodiscard]] static Outcome<std::unique_ptr<FrameRecorder>> start(const RecordingSection& section, const RecordedRig& rig,
                                                                     int width, int height);
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;
  ~FrameRecorder();

  // Copies a frame; from one thread. No heap. may_wait: the source waits too, so a full queue drops nothing.
  // Counts as dropped: no room, a recording that has stopped, a frame older than the one before, which none can hold.
  void take(const CameraFrame& frame, bool may_wait) noexcept;

  // Writes what is queued, ends the thread.
  void finish();

  // --- any thread ---
  [[nodiscard]] std::uint64_t recorded() const { return recorded_.load(std::memory_order_relaxed); }  // on the disk, listed
  [[nodiscard]] std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool stopped() const { return stop_reason_.load(std::memory_order_acquire) != kRecording; }
  // Why it stopped, for a person; empty while it goes on.
  [[nodiscard]] std::string problem() const;
  [[nodiscard]] const std::filesystem::path& folder() const { return recording_.folder(); }

 private:
  struct Queued {
    std::uint64_t sequence = 0;
    std::int64_t time_ns = 0;
    std::uint32_t exposure_us = 0;
    StrobePhase strobe = StrobePhase::kUnstrobed;
    std::uint64_t buffer = 0;
  };
  static constexpr int kRecording = 0, kTooLittleRoom = -1;  // else the errno of a write

  FrameRecorder(DurableRecording recording, const RecordingSection& section, int width, int height,
                std::unique_ptr<std::uint8_t[]> pixels);
  void run();
  void write(const Queued& queued);
  void sync();
  void stop(int reason);
  [[nodiscard]] std::uint8_t* pixels(std::uint64_t buffer) { return pixels_.get() + buffer * image_bytes_; }

  DurableRecording recording_;
  RecordingSection section_;
  int width_, height_;
  std::size_t image_bytes_;
  std::unique_ptr<std::uint8_t[]> pixels_;  // of every place in the queue
  SpscRing<Queued> queue_;
  std::atomic<std::uint64_t> recorded_{0}, dropped_{0};
  std::atomic<int> stop_reason_{kRecording};
  std::atomic<bool> finishing_{false};
  std::thread thread_;

  // Of the frame loop's thread.
  std::uint64_t next_ = 0;
  bool any_ = false;
  std::uint64_t last_sequence_ = 0;
  std::int64_t last_time_ns_ = 0;
};

}  // namespace srd::firmware
