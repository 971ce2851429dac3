// SPDX-License-Identifier: Apache-2.0
// [strobe] of the configuration: which line, which light, how much of it. Keys: board/README.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/camera/frame_timing.hpp"
#include "drivers/strobe/gpiod_line.hpp"
#include "drivers/strobe/scheduler.hpp"

namespace srd {
class TomlTable;
}

namespace srd::firmware {

enum class StrobeMode : std::uint8_t {
  kOff,
  kFollow,   // pulses predicted from the sensor's stamps
  kTrigger,  // the board triggers the camera on a grid of the wall clock; pulses follow the triggers
};
[[nodiscard]] const char* to_string(StrobeMode mode);

struct StrobeSection {
  StrobeMode mode = StrobeMode::kOff;
  std::string chip = "/dev/gpiochip0";
  std::string line;  // empty: triggers without a strobe
  bool active_low = false;
  std::int64_t pulse_us = 500, delay_us = 0, jitter_us = 200;
  std::int64_t max_pulse_us = 2000;
  double max_duty = 0.1;
  StrobePattern pattern;
  std::string pattern_text = "L";
  int dark_difference = 10;  // grey levels
  std::string trigger_line;
  std::int64_t trigger_pulse_us = 100;

  [[nodiscard]] LineAddress line_address() const { return {chip, line, active_low}; }
  [[nodiscard]] LineAddress trigger_address() const { return {chip, trigger_line, false}; }
};

// What the strobe's values have to fit, of [camera].
struct StrobedCamera {
  double frame_rate_hz = 50;
  std::optional<std::int64_t> exposure_us;  // none: the device's own, which nobody knows
  Shutter shutter = Shutter::kGlobal;
  std::int64_t readout_us = 0;
  bool trigger_input = false;
};

// Complaints go to the table, with file and line: values out of range, and light that does not fit the camera's exposure,
// the camera's period or the LEDs' limits.
[[nodiscard]] StrobeSection read_strobe(TomlTable table, const StrobedCamera& camera);

// Relative to a frame's time (CameraFrame::time_ns).
[[nodiscard]] StrobeTiming strobe_timing(const StrobeSection& section, const FrameTiming& frame, double frame_rate_hz);

}  // namespace srd::firmware
