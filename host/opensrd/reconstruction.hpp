// SPDX-License-Identifier: Apache-2.0
// OpenSRD's settings turned into a run, and a run into OpenSRD's files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/recording/recorded_optics.hpp"
#include "host/opensrd/results.hpp"
#include "host/run/pose_estimation.hpp"
#include "host/run/run.hpp"

namespace srd::host::opensrd {

// From the command line; each goes before the settings.
struct Overrides {
  std::optional<double> refractive_index;
  std::optional<dsp::Metric> metric;
  std::optional<std::filesystem::path> features;  // folder of an earlier run: its features instead of images
  std::optional<double> rate_hz;                  // of the images
  bool free_index = false;                        // estimate the index of water
  std::optional<int> model;                       // k2017: parameters of the surface; 2: the release's form
  Plates plates{};                                // on the pattern, from the top down
  int sample_bits = 0;                            // of the images, as read_gray_image takes it
};

struct Preparation {
  RunPlan plan;
  std::vector<std::optional<PoseFit>> fits;  // one a camera; none where the pose came from a file
  std::vector<std::string> head;             // for the summary
  std::vector<std::string> warnings;
};

// Reads and checks everything but the frames; estimates poses. kInput: a file that cannot be used.
[[nodiscard]] Outcome<Preparation> prepare(const Settings& settings, const Overrides& overrides);

// All result files of the plan.
[[nodiscard]] Outcome<void> write_results(const OutputPlan& outputs, const Settings& settings, const Preparation& preparation,
                                          const RunResult& result);

}  // namespace srd::host::opensrd
