// SPDX-License-Identifier: Apache-2.0
// What every camera kind offers: frames, borrowed one by one, with their time. One folder or file per kind below.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/camera/camera_counters.hpp"
#include "drivers/camera/frame_timing.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/core/image_view.hpp"
#include "dsp/core/time.hpp"

namespace srd {

using Nanoseconds = std::chrono::nanoseconds;

// A borrowed frame: valid until give_back. No copy of pixels is made anywhere.
struct CameraFrame {
  GrayView image;
  std::uint64_t sequence = 0;  // of the source; a gap means frames that the source lost
  std::int64_t time_ns = 0;    // middle of the light that made the image
  ClockId clock = ClockId::kUnknown;
  std::uint32_t exposure_us = 0;  // 0: unknown
  StrobePhase strobe = StrobePhase::kUnstrobed;
  std::uint32_t buffer = 0;  // for give_back
};

enum class Capture : std::uint8_t {
  kFrame,         // frame is filled
  kBadFrame,      // one frame could not be had (unreadable image, buffer error); sequence and time are filled; goes on
  kTimeout,       // nothing within the time given
  kDisconnected,  // the device is away; calling again tries to recover
  kEnd,           // a recording is over
};

enum class Pace : std::uint8_t { kCamera, kMax };  // at the recorded rate | as fast as frames are taken

// start, stop and next are called from one thread; give_back from any. After start, next and give_back do not throw.
class Camera {
 public:
  virtual ~Camera() = default;
  // Opens the device, reserves all buffers. Problem says what the device offers when it cannot do what is asked.
  [[nodiscard]] virtual Outcome<void> start() = 0;
  // Waits at most timeout. The caller holds at most buffer_count() frames at a time.
  [[nodiscard]] virtual Capture next(CameraFrame& frame, Nanoseconds timeout) noexcept = 0;
  virtual void give_back(const CameraFrame& frame) noexcept = 0;
  virtual void stop() noexcept = 0;
  // px; valid after start.
  [[nodiscard]] virtual int width() const = 0;
  [[nodiscard]] virtual int height() const = 0;
  [[nodiscard]] virtual int buffer_count() const = 0;
  // True for live devices: frames that nobody takes in time are lost. False: next waits for the caller.
  [[nodiscard]] virtual bool live() const = 0;
  // What time_ns was made with; valid after start. Recordings and the simulator bring their own times.
  [[nodiscard]] virtual FrameTiming timing() const { return {}; }
  // Lines for a person, each with its end; valid after start: what was agreed with the device, and what it cannot do.
  [[nodiscard]] virtual std::string summary() const { return {}; }
  // Valid after start: what of the image the device still changes although it should not (sharpening, autofocus), a control
  // each, in words for a person.
  [[nodiscard]] virtual std::vector<std::string> image_concerns() const { return {}; }
  // Of the thread that calls next: what making grey of a frame takes, a mean since the start. 0: images are taken as they are.
  [[nodiscard]] virtual Nanoseconds conversion_time() const { return Nanoseconds(0); }
  // One for a person, after stop: why a device that went away did not come back. Empty: nothing to say.
  [[nodiscard]] virtual std::string last_words() const { return {}; }
  // From any thread.
  [[nodiscard]] const CameraCounters& faults() const { return faults_; }

 protected:
  CameraCounters faults_;
};

}  // namespace srd
