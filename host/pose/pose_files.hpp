// SPDX-License-Identifier: Apache-2.0
// What `srd pose` leaves: pose.yml, points.txt, report.toml, overlay.png, residuals.png and pose.html.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/pose/height_effect.hpp"
#include "host/pose/point_refinement.hpp"

namespace srd::host {

struct PoseResult {
  MeasuredPose pose;
  StillWater water;  // of the reference
  std::vector<HeightEffect> effects;
  std::optional<PointRefinement> print;  // the pose's points are then these, else the list's
  Points listed;                         // the pattern as it was given
  std::vector<std::string> references;
  std::string calibration_file;
};

[[nodiscard]] std::vector<std::filesystem::path> pose_files(const std::filesystem::path& out);
// Makes the folder. kInput when something cannot be written.
[[nodiscard]] Outcome<void> write_pose_files(PoseResult& result, const std::filesystem::path& out);
// A few lines for stdout.
[[nodiscard]] std::string pose_summary(const PoseResult& result);

}  // namespace srd::host
