// SPDX-License-Identifier: Apache-2.0
#include "firmware/strobe/strobe_section.hpp"

#include <cmath>

#include "drivers/support/toml_reader.hpp"

namespace srd::firmware {

namespace {

template <class T, class U>
void set(T& to, const std::optional<U>& from) {
  if (from) to = static_cast<T>(*from);
}

std::string us(std::int64_t value) { return std::to_string(value) + " us"; }
std::string us(double value) { return us(static_cast<std::int64_t>(std::llround(value))); }

// The pulse must fall while all rows integrate, and the exposure into the frame's period.
void check_exposure(TomlTable& table, const StrobeSection& strobe, const StrobedCamera& camera) {
  const double period_us = 1e6 / camera.frame_rate_hz;
  if (!camera.exposure_us) {
    table.complain("mode", "camera.exposure_us: pulses are placed in the exposure", "none",
                   "set camera.exposure_us, or strobe.mode = \"off\"");
    return;
  }
  const std::int64_t exposure = *camera.exposure_us;
  const bool rolling = camera.shutter == Shutter::kRolling;
  const std::int64_t readout = rolling ? camera.readout_us : 0;
  // A triggered sensor does not expose while it reads out.
  const bool triggered = strobe.mode == StrobeMode::kTrigger;
  const std::int64_t busy = exposure + (triggered ? camera.readout_us : 0);
  if (static_cast<double>(busy) > period_us)
    table.complain(
        "mode",
        std::string(triggered ? "an exposure and readout" : "an exposure") + " of at most the frame's period, " + us(period_us),
        us(busy), "lower camera.exposure_us or camera.frame_rate_hz");
  if (strobe.line.empty()) return;
  const std::int64_t needed = readout + strobe.pulse_us + strobe.jitter_us;
  if (exposure < needed)
    table.complain("pulse_us",
                   "camera.exposure_us of at least " +
                       (rolling ? "camera.readout_us + strobe.pulse_us + strobe.jitter_us = " + std::to_string(readout) + " + "
                                : std::string("strobe.pulse_us + strobe.jitter_us = ")) +
                       std::to_string(strobe.pulse_us) + " + " + std::to_string(strobe.jitter_us) + " = " + us(needed) +
                       (rolling ? ", so that the light reaches all rows of a rolling shutter" : ""),
                   us(exposure), "lengthen the exposure, or shorten the pulse");
}

void check_light(TomlTable& table, const StrobeSection& strobe, const StrobedCamera& camera) {
  if (strobe.pulse_us > strobe.max_pulse_us)
    table.complain("pulse_us", "at most strobe.max_pulse_us, " + us(strobe.max_pulse_us), us(strobe.pulse_us));
  const double share = static_cast<double>(strobe.pattern.lit_count()) / strobe.pattern.length;
  const double duty = static_cast<double>(strobe.pulse_us) * 1e-6 * camera.frame_rate_hz * share;
  if (duty > strobe.max_duty * (1 + 1e-9)) {
    const auto text = [](double value) { return std::to_string(value).substr(0, 6); };
    table.complain("pulse_us",
                   "a duty of at most strobe.max_duty, " + text(strobe.max_duty) + ": at most " +
                       us(std::floor(strobe.max_duty / (1e-6 * camera.frame_rate_hz * share))) + " at this rate and pattern",
                   us(strobe.pulse_us) + ", a duty of " + text(duty), "shorten the pulse, or light fewer frames");
  }
}

void check_trigger(TomlTable& table, const StrobeSection& strobe, const StrobedCamera& camera) {
  if (!camera.trigger_input)
    table.complain("mode", "camera.trigger_input = true: a sensor that exposes when its trigger line is pulsed", "\"trigger\"",
                   "wire and declare the input, or use strobe.mode = \"follow\"");
  if (strobe.trigger_line.empty()) table.missing("trigger_line", "the GPIO line of the camera's trigger input");
  if (!strobe.trigger_line.empty() && strobe.trigger_line == strobe.line)
    table.complain("trigger_line", "another line than strobe.line", "\"" + strobe.trigger_line + "\"");
  if (static_cast<double>(strobe.trigger_pulse_us) > 0.5e6 / camera.frame_rate_hz)
    table.complain("trigger_pulse_us", "at most half the frame's period, " + us(0.5e6 / camera.frame_rate_hz),
                   us(strobe.trigger_pulse_us));
}

}  // namespace

const char* to_string(StrobeMode mode) {
  switch (mode) {
    case StrobeMode::kOff: return "off";
    case StrobeMode::kFollow: return "follow";
    case StrobeMode::kTrigger: return "trigger";
  }
  return "off";
}

StrobeSection read_strobe(TomlTable table, const StrobedCamera& camera) {
  StrobeSection strobe;
  if (auto mode = table.choice("mode", {"off", "follow", "trigger"}))
    strobe.mode = *mode == "follow" ? StrobeMode::kFollow : *mode == "trigger" ? StrobeMode::kTrigger : StrobeMode::kOff;
  set(strobe.chip, table.text("chip"));
  set(strobe.line, table.name_or_number("line"));
  set(strobe.active_low, table.boolean("active_low"));
  set(strobe.pulse_us, table.integer("pulse_us", {1, 1e6, "us"}));
  set(strobe.delay_us, table.integer("delay_us", {0, 1e5, "us"}));
  set(strobe.jitter_us, table.integer("jitter_us", {1, 1e5, "us"}));
  set(strobe.max_pulse_us, table.integer("max_pulse_us", {1, 1e6, "us"}));
  set(strobe.max_duty, table.number("max_duty", {0.0001, 1}));
  set(strobe.dark_difference, table.integer("dark_difference", {1, 255, "grey levels"}));
  set(strobe.trigger_line, table.name_or_number("trigger_line"));
  set(strobe.trigger_pulse_us, table.integer("trigger_pulse_us", {1, 1e6, "us"}));
  if (auto text = table.text("pattern")) {
    if (auto pattern = StrobePattern::parse(*text)) {
      strobe.pattern = *pattern;
      strobe.pattern_text = *text;
    } else {
      table.complain("pattern", "1 to 32 letters L (lit) and D (dark), at least one L, such as \"LD\"", "\"" + *text + "\"");
    }
  }
  if (strobe.mode == StrobeMode::kOff) return strobe;
  const bool numbered = strobe.line.find_first_not_of("0123456789") == std::string::npos;
  if (strobe.mode == StrobeMode::kFollow && strobe.line.empty())
    table.missing("line", "the GPIO line of the strobe, a number or a name");
  else if (strobe.chip.empty() && !strobe.line.empty() && numbered)
    table.complain("chip", "the chip of line " + strobe.line, "none", "name the chip, or give the line's name");
  check_exposure(table, strobe, camera);
  if (!strobe.line.empty()) check_light(table, strobe, camera);
  if (strobe.mode == StrobeMode::kTrigger) check_trigger(table, strobe, camera);
  return strobe;
}

StrobeTiming strobe_timing(const StrobeSection& section, const FrameTiming& frame, double frame_rate_hz) {
  StrobeTiming timing;
  const TimeWindow window = frame.all_rows(frame.exposure_start_of_middle_ns(0));
  timing.window_begin_ns = window.begin_ns;
  timing.window_end_ns = window.end_ns;
  timing.pulse_ns = 1000 * section.pulse_us;
  timing.delay_ns = 1000 * section.delay_us;
  timing.jitter_ns = 1000 * section.jitter_us;
  timing.max_pulse_ns = 1000 * section.max_pulse_us;
  timing.max_duty_ppm = std::llround(1e6 * section.max_duty);
  timing.pattern = section.pattern;
  if (section.mode == StrobeMode::kTrigger) {
    timing.trigger_rate_mhz = std::llround(1000 * frame_rate_hz);
    timing.trigger_pulse_ns = 1000 * section.trigger_pulse_us;
    timing.stamp_after_trigger_ns = frame.middle_offset_ns();
  }
  return timing;
}

}  // namespace srd::firmware
