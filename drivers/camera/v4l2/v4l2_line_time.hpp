// SPDX-License-Identifier: Apache-2.0
// How long a sensor takes for one line: raw sensors count their exposure in lines. At start, not in the loop.
#pragma once

#include <optional>

#include "drivers/camera/v4l2/v4l2_port.hpp"
#include "drivers/camera/v4l2/v4l2_settings.hpp"

namespace srd {

// (width of the sensor's crop + V4L2_CID_HBLANK) / V4L2_CID_PIXEL_RATE, ns, as the kernel's documentation of raw sensors defines
// a line; where the device tells no crop, the width of its format. Nothing: the device does not tell its pixel rate or blanking.
[[nodiscard]] std::optional<double> v4l2_line_time_ns(V4l2Port& port, const V4l2Settings& settings) noexcept;

}  // namespace srd
