// SPDX-License-Identifier: Apache-2.0
#include "firmware/doctor/pulse_check.hpp"

#include "drivers/support/formatted.hpp"

namespace srd::firmware {

bool check_exposure(const StrobeSection& section, const FrameTiming& timing, Diagnosis& diagnosis) {
  if (timing.exposure_ns <= 0) {
    diagnosis.warn("exposure", "unknown: nobody can tell whether the strobe's pulses fit into it",
                   "camera.exposure_us, for a camera that does not tell its exposure");
    return false;
  }
  const double window = static_cast<double>(timing.all_rows(0).length_ns()) / 1e3,
               exposure = static_cast<double>(timing.exposure_ns) / 1e3;
  const bool rolling = timing.shutter == Shutter::kRolling;
  const std::string rows = rolling ? formatted(", in which all rows integrate together for %.0f us", window) : std::string();
  const auto needed = static_cast<double>(section.pulse_us + section.jitter_us);
  if (window >= needed) return true;
  const char* too_short = window < static_cast<double>(section.pulse_us) ? "shorter than" : "too short for";
  diagnosis.fail(Exit::kDevice, "exposure",
                 formatted("%.0f us", exposure) + rows + ": " + too_short +
                     formatted(" the strobe's pulses, strobe.pulse_us + strobe.jitter_us = %.0f us", needed),
                 formatted("camera.exposure_us of at least %.0f, or shorter pulses",
                           needed + (rolling ? static_cast<double>(timing.readout_ns) / 1e3 : 0)));
  return false;
}

void check_pulses(const StrobeSection& section, const StrobeReport& report, const StrobedLevels& levels, Diagnosis& diagnosis) {
  if (report.pulses == 0) return;  // the light's finding tells
  const std::string pulses = formatted("%llu pulses", static_cast<unsigned long long>(report.pulses));
  if (section.pattern.has_dark() && levels.lit && levels.dark && *levels.lit - *levels.dark < section.dark_difference) {
    diagnosis.warn(
        "pulses",
        pulses + formatted(", and frames with one are as dark as those without (grey level %.0f and %.0f): they lie "
                           "outside of the exposure, or light nothing",
                           *levels.lit, *levels.dark),
        "camera.stamp, camera.readout_us and strobe.delay_us, which say where the exposure lies; the LEDs and their line");
    return;
  }
  if (report.shift != 0) {
    diagnosis.warn("pulses", pulses + formatted(", seen %d exposures later than the stamps say", report.shift),
                   "camera.stamp and camera.readout_us, which say where the exposure lies");
    return;
  }
  if (report.spilled > 0) {
    diagnosis.warn(
        "pulses", formatted("%llu of ", static_cast<unsigned long long>(report.spilled)) + pulses + " ended after the exposure",
        "a longer camera.exposure_us or shorter strobe.pulse_us, real-time priority (below)");
    return;
  }
  if (report.early > 0) {
    diagnosis.warn("pulses",
                   pulses + formatted("; %llu frames came before the middle of their exposure",
                                      static_cast<unsigned long long>(report.early)),
                   "camera.stamp and camera.readout_us, which say where the exposure lies");
    return;
  }
  diagnosis.ok("pulses", pulses + ", none outside of the exposure");
}

}  // namespace srd::firmware
