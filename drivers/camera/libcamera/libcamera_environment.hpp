// SPDX-License-Identifier: Apache-2.0
// What libcamera takes from the environment when it starts, set here where the user has not: what it logs, and how long the
// Raspberry Pi's cameras may give no frame.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace srd {

// "pisp" or "bcm2835" as its pipeline configurations are headed, by the device tree's compatible strings, each with a zero
// byte behind it; empty: no Raspberry Pi.
[[nodiscard]] std::string raspberrypi_target(std::string_view compatible);

// The configuration that lets its cameras wait for a day: its own limit is a few frames' time, a second or so, after which it
// stops a camera that waits for its triggers.
[[nodiscard]] std::string raspberrypi_patience(const std::string& target);

// Before libcamera starts, and before the program has threads: LIBCAMERA_LOG_LEVELS lets only errors through; with
// trigger_input, on a Raspberry Pi, LIBCAMERA_RPI_CONFIG_FILE names a configuration as above, which exists as long as the program.
// What the user has set stays. root: where /proc is; another folder in tests.
void prepare_libcamera(bool trigger_input, const std::filesystem::path& root = "/");

// For a person, after prepare_libcamera.
struct LibcameraSetting {
  std::string subject, found;
  std::string advice;  // empty: good as it is
};
[[nodiscard]] std::vector<LibcameraSetting> libcamera_settings(bool trigger_input, const std::filesystem::path& root = "/");

}  // namespace srd
