// Exposure and gain of a capture device: what is asked, as controls that it has. At start, not in the loop.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/v4l2/v4l2_port.hpp"
#include "drivers/camera/v4l2/v4l2_settings.hpp"

namespace srd {

struct V4l2ControlPlan {
  std::int64_t exposure_ns = 0;    // that the frames will have; 0: unknown
  std::vector<std::string> notes;  // what a person should know: values clamped, controls that are missing
};

// Sets, and adds to settings, what switches automatic exposure and gain off and then the values, in the order in which
// the device needs them. exposure_us, gain (in the device's own units): none, left as they are. What the device cannot do is a note.
[[nodiscard]] V4l2ControlPlan plan_controls(V4l2Port& port, std::optional<std::int64_t> exposure_us,
                                            std::optional<double> gain, V4l2Settings& settings);

}  // namespace srd
