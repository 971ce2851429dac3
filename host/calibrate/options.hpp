// SPDX-License-Identifier: Apache-2.0
// What a person asks of srd calibrate.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/board_views.hpp"

namespace srd::host {

struct CalibrateOptions {
  std::vector<std::filesystem::path> sources;  // images, folders of images, or one OpenSRD settings file
  std::filesystem::path out;
  bool force = false;
  std::string board;             // "17x7": inner corners along and across; empty: the settings'
  std::optional<double> square;  // mm
  bundle::CameraOptions camera;
  BoardSearch search;
};

// Sources and settings resolved.
struct CalibratePlan {
  std::vector<std::filesystem::path> images;  // in the order given, folders in natural order; each once
  bundle::BoardShape board;
  std::string calibration_name = "calibration.yml";
  bundle::CameraOptions camera;
  BoardSearch search;
  std::vector<std::string> warnings;
};

// kUsage or kInput: board or side of a square missing or absurd, no image, an image twice, settings that are none of a
// calibration.
[[nodiscard]] Outcome<CalibratePlan> plan_calibration(const CalibrateOptions& options);

}  // namespace srd::host
