// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/libcamera/libcamera_environment.hpp"

#include <unistd.h>

#include <cstdlib>
#include <optional>

#include "drivers/support/text_file.hpp"
#include "drivers/support/unique_fd.hpp"

namespace srd {

namespace {

constexpr const char* kLogLevels = "LIBCAMERA_LOG_LEVELS";
constexpr const char* kErrorsOnly = "*:ERROR";
constexpr const char* kPiFile = "LIBCAMERA_RPI_CONFIG_FILE";
constexpr const char* kPatience = "camera_timeout_value_ms";
constexpr long kDayMs = 86'400'000;

std::string target_of_board(const std::filesystem::path& root) {
  const auto compatible = read_text_file(root / "proc/device-tree/compatible", "a device tree", 4096);
  return compatible ? raspberrypi_target(*compatible) : std::string();
}

// A name under which the text can be read for as long as the program runs, and which needs no cleaning up.
std::optional<std::string> lasting_file(const std::string& text) {
  static UniqueFd kept;
  std::error_code error;
  std::string name = (std::filesystem::temp_directory_path(error) / "srd-node-libcamera-XXXXXX").string();
  if (error) return std::nullopt;
  UniqueFd file(::mkstemp(name.data()));
  if (!file.valid()) return std::nullopt;
  ::unlink(name.c_str());
  if (::write(file.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) return std::nullopt;
  kept = std::move(file);
  return "/proc/self/fd/" + std::to_string(kept.get());
}

std::string value_of(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : value;
}

}  // namespace

std::string raspberrypi_target(std::string_view compatible) {
  const std::string whole = std::string(1, '\0') + std::string(compatible) + std::string(1, '\0');
  const auto has = [&](const char* chip) {
    return whole.find(std::string(1, '\0') + "brcm," + chip + std::string(1, '\0')) != std::string::npos;
  };
  if (has("bcm2712")) return "pisp";
  for (const char* chip : {"bcm2711", "bcm2837", "bcm2836", "bcm2835"})
    if (has(chip)) return "bcm2835";
  return {};
}

std::string raspberrypi_patience(const std::string& target) {
  return "{ \"version\": 1.0, \"target\": \"" + target + "\", \"pipeline_handler\": { \"" + kPatience +
         "\": " + std::to_string(kDayMs) + " } }\n";
}

void prepare_libcamera(bool trigger_input, const std::filesystem::path& root) {
  ::setenv(kLogLevels, kErrorsOnly, 0);
  if (!trigger_input || std::getenv(kPiFile) != nullptr) return;
  const std::string target = target_of_board(root);
  if (target.empty()) return;
  if (const auto file = lasting_file(raspberrypi_patience(target))) ::setenv(kPiFile, file->c_str(), 0);
}

std::vector<LibcameraSetting> libcamera_settings(bool trigger_input, const std::filesystem::path& root) {
  std::vector<LibcameraSetting> settings;
  const std::string levels = value_of(kLogLevels), file = value_of("LIBCAMERA_LOG_FILE");
  settings.push_back({"libcamera's log",
                      std::string(kLogLevels) + "=" + levels + ", to " + (file.empty() ? "here" : file) +
                          (levels == kErrorsOnly ? "; *:INFO in the environment shows more" : ""),
                      ""});
  if (!trigger_input || target_of_board(root).empty()) return settings;
  const std::string subject = "libcamera's patience", configuration = value_of(kPiFile);
  const std::string advice = std::string("a file with ") + kPatience + " in its pipeline_handler, such as " +
                             std::to_string(kDayMs) + "; or leave " + kPiFile + " unset: srd-node then raises it itself";
  if (configuration.empty()) {
    settings.push_back({subject, "a camera that waits for its triggers is stopped after a second or so", advice});
  } else if (configuration.starts_with("/proc/self/fd/")) {
    settings.push_back({subject, "raised to a day: the camera waits for its triggers", ""});
  } else {
    const auto text = read_text_file(configuration, "a configuration of libcamera's", 1 << 20);
    bool says = false;
    if (text)
      for (const TextLine& line : split_lines(*text)) {
        const std::string_view words = trimmed(line.text);
        says = says || (!words.starts_with('#') && words.find(kPatience) != std::string_view::npos);
      }
    settings.push_back({subject, std::string(kPiFile) + "=" + configuration + (says ? " says how long" : " does not raise it"),
                        says ? "" : advice});
  }
  return settings;
}

}  // namespace srd
