// SPDX-License-Identifier: Apache-2.0
// Settings put into an open device. No heap, no exception: used at the start and when a device comes back.
#pragma once

#include "drivers/camera/v4l2/v4l2_port.hpp"
#include "drivers/camera/v4l2/v4l2_settings.hpp"

namespace srd {

// What VIDIOC_S_FMT answered.
struct V4l2Layout {
  int stride_bytes = 0;
  int planes = 1;
};

// A format of the kinds of settings; size and code as wanted, progressive.
[[nodiscard]] v4l2_format v4l2_format_request(const V4l2Settings& settings) noexcept;
struct V4l2Answer {
  std::uint32_t code = 0;
  int width = 0, height = 0;
  std::uint32_t field = V4L2_FIELD_NONE;
  V4l2Layout layout;
};
[[nodiscard]] V4l2Answer read_answer(const v4l2_format& format, bool multi_planar) noexcept;

// Timings, format, interval, controls, in that order (the later depend on the earlier).
[[nodiscard]] V4l2Failure apply_settings(V4l2Port& port, const V4l2Settings& settings, V4l2Layout& layout) noexcept;

// The timings of the signal that is plugged in, if there is one, become the device's. Nothing is set when they are.
[[nodiscard]] int take_detected_timings(V4l2Port& port) noexcept;

// Two rates that are the same to 1 %.
[[nodiscard]] constexpr bool same_rate(double a_hz, double b_hz) {
  return a_hz - b_hz <= 0.01 * b_hz && b_hz - a_hz <= 0.01 * b_hz;
}

}  // namespace srd
