// SPDX-License-Identifier: Apache-2.0
// What the command line of srd reconstruct says.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/recording/recorded_optics.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/estimate/estimator/estimator.hpp"

namespace srd::host {

struct ReconstructOptions {
  std::filesystem::path source;  // settings.xml or the folder of a recording
  std::filesystem::path out;
  bool force = false;
  std::optional<double> refractive_index;  // with free_index, where every frame starts
  bool free_index = false;                 // estimate it
  Plates plates;                           // --plate; none: the recording's, else none
  std::optional<dsp::Metric> metric;
  dsp::Loss loss = dsp::Loss::kNone;
  std::optional<double> rate_hz;
  int sample_bits = 0;  // --bits; 0: as read_gray_image
  // OpenSRD settings only.
  std::optional<std::filesystem::path> features;
  std::optional<int> model;  // parameters; 2: level-normal, for settings of the 2017 release only
  int threads = 1;           // >= 1
  // Recordings only: the settings say these themselves.
  std::vector<std::string> modes;
  std::optional<double> lx, ly;  // mm
  std::vector<double> guess;     // mm
};

[[nodiscard]] Outcome<void> reconstruct_settings(const ReconstructOptions& options);
[[nodiscard]] Outcome<void> reconstruct_recording(const ReconstructOptions& options);

}  // namespace srd::host
