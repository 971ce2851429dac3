// SPDX-License-Identifier: Apache-2.0
// A running capture: the driver's buffers mapped once, taken and given back. No heap, no exception, so that a device
// which went away can be taken up again in the frame loop.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>

#include "drivers/camera/camera_counters.hpp"
#include "drivers/camera/frame_timing.hpp"
#include "drivers/camera/v4l2/v4l2_port.hpp"
#include "drivers/camera/v4l2/v4l2_settings.hpp"
#include "drivers/support/mapped_region.hpp"
#include "dsp/core/time.hpp"

namespace srd {

// One buffer that the driver filled.
struct V4l2Taken {
  std::uint32_t buffer = 0;
  std::uint32_t sequence = 0;  // the driver's, 32 bits
  std::int64_t stamp_ns = 0;   // of clock(); 0: none
  std::uint32_t bytes = 0;     // from the image's beginning
  bool damaged = false;        // marked so, or shorter than an image
};

// give_back from any thread; all else from one.
class V4l2Stream {
 public:
  enum class Take : std::uint8_t { kTaken, kNothing, kGone };

  V4l2Stream(V4l2Port& port, CameraCounters& faults) : port_(port), faults_(faults) {}
  ~V4l2Stream() { stop(); }
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  // On an open device. After a failure nothing is held. least_stride: bytes of a row of pixels; 0 when compressed.
  [[nodiscard]] V4l2Failure start(const V4l2Settings& settings, int least_stride) noexcept;
  // Ends the stream, undoes the mappings and closes the device. Only when borrowed() is 0: borrowed images vanish.
  void stop() noexcept;
  // The oldest filled buffer, which is the caller's until give_back. Does not wait.
  [[nodiscard]] Take take(V4l2Taken& taken) noexcept;
  void give_back(std::uint32_t buffer) noexcept;
  // Buffers that the driver did not take back are offered to it again.
  void requeue_idle() noexcept;

  [[nodiscard]] int borrowed() const noexcept;
  [[nodiscard]] int queued() const noexcept;
  [[nodiscard]] int buffers() const noexcept { return count_; }
  [[nodiscard]] const std::uint8_t* pixels(std::uint32_t buffer) const noexcept {
    return slots_[buffer].region.data() + slots_[buffer].offset;
  }
  [[nodiscard]] int stride_bytes() const noexcept { return stride_; }
  // What the driver's stamps are; known once started.
  [[nodiscard]] ClockId clock() const noexcept { return clock_; }
  [[nodiscard]] StampMark mark() const noexcept { return mark_; }

 private:
  enum class Holder : std::uint8_t { kNobody, kDriver, kCaller };
  struct Slot {
    MappedRegion region;
    std::uint32_t offset = 0;  // of the image in the region, bytes
    Holder holder = Holder::kNobody;
  };
  V4l2Failure set_up(const V4l2Settings& settings, int least_stride) noexcept;
  int queue(std::uint32_t buffer) noexcept;
  void read_flags(std::uint32_t flags) noexcept;
  int count(Holder holder) const noexcept;

  V4l2Port& port_;
  CameraCounters& faults_;
  mutable std::mutex mutex_;  // of the slots' holders and of open_; held over a queueing call
  std::array<Slot, FramePool::kMaxBuffers> slots_;
  bool open_ = false;
  int count_ = 0, stride_ = 0, planes_ = 1;
  std::int64_t image_bytes_ = 0;
  bool multi_planar_ = false;
  std::uint32_t type_ = 0;
  ClockId clock_ = ClockId::kUnknown;
  StampMark mark_ = StampMark::kFrameEnd;
};

}  // namespace srd
