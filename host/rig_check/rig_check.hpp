// SPDX-License-Identifier: Apache-2.0
// Has the camera or the pattern moved between two images? Only their places against each other show: which of the two has
// moved, one camera cannot tell.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dsp/pose/pose_comparison.hpp"
#include "host/pose/measured_pose.hpp"

namespace srd::host {

struct RigRequest {
  PoseRequest reference;  // with its water, where the reference is wet
  std::vector<std::filesystem::path> later;
  StillWater later_water;
  double false_alarm = 1e-6;  // of an unmoved rig, in (0, 1)
  double least_px = 0.02;     // moves that shift every corner by less are none: what the detector's own errors can be
};

struct RigComparison {
  dsp::PoseComparison poses;
  bool significant = false;  // by_chance below the false alarm rate
  bool moved = false;        // significant, and some corner shifts by least_px or more
  int corners = 0;
  double turn_deg = 0, turn_deviation_deg = 0;  // the whole turn, and its deviation along itself
  dsp::Vec3<double> turn_axis;                  // in C
  dsp::Vec3<double> shift, shift_deviation;     // of the camera's centre in W, mm
  double largest_move_mm = 0;                   // of largest_move_px on the pattern
  std::vector<std::string> warnings;
};

// Problems as measure_pose has them, of either image.
[[nodiscard]] Outcome<RigComparison> check_rig(RigRequest request);

// What a person reads; the verdict first.
[[nodiscard]] std::string rig_text(const RigComparison& found, const RigRequest& request);
// The same as TOML.
[[nodiscard]] std::string rig_toml(const RigComparison& found, const RigRequest& request);

}  // namespace srd::host
