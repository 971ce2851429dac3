// SPDX-License-Identifier: Apache-2.0
// Exposure, gain, focus and what would change the image of a capture device: what is asked, as controls that it has. At start, not in the loop.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/v4l2/v4l2_port.hpp"
#include "drivers/camera/v4l2/v4l2_settings.hpp"

namespace srd {

struct V4l2ControlAsk {
  std::optional<std::int64_t> exposure_us;  // none of these: left as they are
  std::optional<double> gain;               // in the device's own units
  std::optional<double> sharpness;          // none: the least
  std::optional<double> focus;              // none: the lens stays where it is
};

struct V4l2ControlPlan {
  std::int64_t exposure_ns = 0;       // that the frames will have; 0: unknown
  std::vector<std::string> notes;     // what a person should know: values clamped, controls that are missing
  std::vector<std::string> concerns;  // what of the image the device still changes: Camera::image_concerns
};

// settings: format and size are agreed. An exposure in lines is converted where the device tells how long a line is.
// Sets, and adds to settings, what switches automatic exposure and gain off and then the values, in the order in which
// the device needs them. Sharpening, automatic focus and white balance, backlight compensation, wide dynamic range,
// stabilisation and the power-line filter are off or at their least, contrast and gamma neutral, where the device has them:
// they move edges, or change from frame to frame. What the device cannot do is a note.
[[nodiscard]] V4l2ControlPlan plan_controls(V4l2Port& port, const V4l2ControlAsk& ask, V4l2Settings& settings);

}  // namespace srd
