// SPDX-License-Identifier: Apache-2.0
// A recording of a rendered scene, with everything that is known of it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "drivers/camera/simulator/scene.hpp"
#include "drivers/recording/recording.hpp"
#include "drivers/support/problem.hpp"

namespace srd::host {

struct SimulationOptions {
  std::filesystem::path out;
  bool force = false;  // replace a recording that is there
  ImageFormat format = ImageFormat::kPng;
  // Called after each frame with the number done and the number of all; may be empty.
  std::function<void(int done, int all)> progress;
};

// Writes images, frames.csv, calibration.yml, pose.yml, points.txt, truth.csv, truth_pixels.csv (u, v of
// every point, a row a frame), scene.toml (scene_text as given) and, when the scene asks for it,
// reference.png with reference_truth_pixels.csv. kUsage when one of them is there and force is not given;
// nothing is written then.
[[nodiscard]] Outcome<void> write_simulation(const Scene& scene, std::string_view scene_text, const SimulationOptions& options);

}  // namespace srd::host
