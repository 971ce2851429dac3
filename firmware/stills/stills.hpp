// SPDX-License-Identifier: Apache-2.0
// srd-node --stills: images for srd calibrate and srd pose, each taken only when the board in it is sharp and stands still.
// Nothing is measured, so neither calibration nor pose is needed.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "drivers/camera/camera.hpp"
#include "firmware/config/node_config.hpp"
#include "firmware/doctor/lit_frames.hpp"

namespace srd::firmware {

struct StillLimits {
  double most_shift_px = 0.1;                             // between two frames that are kBetween apart
  double most_blur_px = 2;                                // of the edges: beyond, corners scatter more than they have to
  static constexpr std::int64_t kBetweenNs = 40'000'000;  // by the frames' times: a hand that seems to rest for 2 ms does not
  static constexpr std::int64_t kPatienceNs = 2'000'000'000;  // that one still is tried for
};

struct StillsOptions {
  std::filesystem::path folder;
  std::optional<double> every_s;  // without being asked; then only of a board that is elsewhere than in the still before
  std::uint64_t count = 0;        // end after so many; 0: when told to, or at the camera's end
  StillLimits limits;
  // True once each time that a person asks for a still; called once a frame, ten times a second without one.
  std::function<bool()> asked = [] { return false; };
  std::function<void(const std::string& lines)> notify = [](const std::string&) {};
};

struct StillsReport {
  std::uint64_t taken = 0, refused = 0;
  std::string last_reason;  // why the last one was not taken
};

// From a camera that has started; frames: of it. kInput when the folder does not take them.
[[nodiscard]] Outcome<StillsReport> take_stills(Camera& camera, LitFrames& frames, const StillsOptions& options,
                                                const std::atomic<bool>& stop);

// Makes and starts what the configuration's [camera] and [strobe] say. A live camera's size is camera.width_px, .height_px, or
// that of the calibration where there is one; kUsage without either. kInput when the camera has ended and no still is taken.
[[nodiscard]] Outcome<StillsReport> run_stills(const NodeConfig& config, const StillsOptions& options,
                                               const std::atomic<bool>& stop);

}  // namespace srd::firmware
