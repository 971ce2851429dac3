// SPDX-License-Identifier: Apache-2.0
// srd pose: where a camera is, from images of the pattern.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dsp/optics/media.hpp"
#include "host/pose/measured_pose.hpp"

namespace CLI {
class App;
}

namespace srd::host {

void add_pose_command(CLI::App& app, int& exit_code);

// Options by which srd pose and srd rig-check name the pattern and the detector's settings. values: lives as long as the
// command.
struct PatternOptions {
  std::string points, board, position_corner;
  OriginSquare origin = OriginSquare::kDark;
  std::optional<double> square_mm;
  int position = 0;
  CornerSearch search{5, 200, 8};
};
void add_pattern_options(CLI::App& command, PatternOptions& values);
// kUsage for what cannot be meant.
[[nodiscard]] Outcome<void> take_pattern_options(const PatternOptions& values, PoseRequest& request);

// Options by which both name the water and the floor plates. values: lives as long as the command.
struct MediaOptions {
  std::optional<double> index;
  std::vector<std::string> plates;
};
void add_media_options(CLI::App& command, MediaOptions& values);
// kUsage for a plate that is none.
[[nodiscard]] Outcome<dsp::Media<double>> media_of(const MediaOptions& values);

}  // namespace srd::host
