// SPDX-License-Identifier: Apache-2.0
// What is agreed with a capture device before its stream starts. Finds it out with the device open; at start only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/v4l2/v4l2_format.hpp"
#include "drivers/camera/v4l2/v4l2_offers.hpp"
#include "drivers/camera/v4l2/v4l2_settings.hpp"
#include "drivers/support/problem.hpp"

namespace srd {

struct V4l2Ask {
  std::string path;             // "/dev/video0"
  std::string format = "auto";  // a name of kV4l2Formats
  int width = 0, height = 0;    // px, of the grey image: half of a mosaic's
  MosaicGray mosaic = MosaicGray::kGreen;
  std::optional<double> rate_hz;
  bool rate_required = false;  // a device that cannot do rate_hz to 1 % is refused; else its own rate is a note
  std::optional<std::int64_t> exposure_us;
  std::optional<double> gain;       // in the device's units
  std::optional<double> sharpness;  // in the device's units; none: its least
  std::optional<double> focus;      // in the device's units; none: the lens stays where it is
  int buffers = 4;                  // 3 to FramePool::kMaxBuffers
};

struct V4l2Plan {
  V4l2Settings settings;
  V4l2PixelFormat format{};
  V4l2Identity identity;
  double rate_hz = 0;                 // 0: unknown
  std::int64_t exposure_ns = 0;       // 0: unknown
  std::vector<std::string> notes;     // clamped values, what cannot be set
  std::vector<std::string> concerns;  // Camera::image_concerns
};

// Opens the device, tries and sets what is asked, and leaves it open and without buffers. kDevice, with what the
// device offers, when it cannot be had.
[[nodiscard]] Outcome<V4l2Plan> plan_capture(V4l2Port& port, const V4l2Ask& ask);

// A failure of a step with its errno, in words: who holds the device, which group to join.
[[nodiscard]] Problem problem_of(const V4l2Failure& failure, const std::string& path);
// One line, without a heading: "setting its format: No such device", "it offers 640x480 GREY instead".
[[nodiscard]] std::string failure_text(const V4l2Failure& failure);

}  // namespace srd
