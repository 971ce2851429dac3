// SPDX-License-Identifier: Apache-2.0
// What a capture device is told, at the start and again when it comes back: plain numbers, so that neither needs the heap.
#pragma once

#include <linux/videodev2.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/camera/frame_pool.hpp"

namespace srd {

struct V4l2Control {
  std::uint32_t id = 0;
  std::int32_t value = 0;
};

struct V4l2Settings {
  static constexpr int kMaxControls = 20;

  std::uint32_t code = 0;       // V4L2_PIX_FMT_*
  int width = 0, height = 0;    // px, of the device's image
  bool compressed = false;      // frames have no rows, and each its own length
  bool multi_planar = false;    // the device's kind of interface, not the format's
  bool detect_timings = false;  // an HDMI or SDI input: take the timings of what is plugged in
  bool set_interval = false;    // the device lets its frame rate be set
  v4l2_fract interval{0, 0};    // s; 0/0: unknown
  std::array<V4l2Control, kMaxControls> controls{};
  int control_count = 0;
  int buffers = 4;  // at most FramePool::kMaxBuffers

  [[nodiscard]] std::uint32_t buffer_type() const {
    return multi_planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  }
  [[nodiscard]] std::int64_t period_ns() const {
    if (interval.numerator == 0 || interval.denominator == 0) return 0;
    return static_cast<std::int64_t>(interval.numerator) * 1'000'000'000 / interval.denominator;
  }
  void add_control(std::uint32_t id, std::int32_t value) {
    if (control_count < kMaxControls) controls[static_cast<std::size_t>(control_count++)] = {id, value};
  }
};

// Where setting a device up ended, for a text made later.
enum class V4l2Step : std::uint8_t {
  kDone,
  kOpen,
  kCapability,
  kTimings,
  kFormat,
  kInterval,
  kControl,
  kBuffers,
  kMap,
  kQueue,
  kStreamOn,
  kStalled,
};

struct V4l2Failure {
  V4l2Step step = V4l2Step::kDone;
  int error = 0;              // errno; 0: the device did something else than it was asked
  std::uint32_t code = 0;     // of kFormat: what the device offered instead
  int width = 0, height = 0;  // px
  [[nodiscard]] bool any() const { return step != V4l2Step::kDone; }
};

[[nodiscard]] constexpr const char* to_string(V4l2Step step) {
  switch (step) {
    case V4l2Step::kDone: return "done";
    case V4l2Step::kOpen: return "opening it";
    case V4l2Step::kCapability: return "asking what it can do";
    case V4l2Step::kTimings: return "setting its input's timings";
    case V4l2Step::kFormat: return "setting its format";
    case V4l2Step::kInterval: return "setting its frame rate";
    case V4l2Step::kControl: return "setting its controls";
    case V4l2Step::kBuffers: return "reserving its buffers";
    case V4l2Step::kMap: return "mapping its buffers";
    case V4l2Step::kQueue: return "queueing its buffers";
    case V4l2Step::kStreamOn: return "starting its stream";
    case V4l2Step::kStalled: return "waiting for a frame";
  }
  return "";
}

}  // namespace srd
