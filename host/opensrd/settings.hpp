// SPDX-License-Identifier: Apache-2.0
// OpenSRD's settings.xml in its three dialects, read by key, with every path resolved and every number checked.
// Dialects, keys and rules: the user guide 3.3 (kGuide), the code of 2016 (k2016) and the release of 2017 (k2017).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"
#include "dsp/core/image_view.hpp"
#include "dsp/estimate/estimator/estimator.hpp"
#include "host/run/pattern_size.hpp"

namespace srd::host::opensrd {

enum class Dialect { kGuide, k2016, k2017 };
[[nodiscard]] const char* to_string(Dialect dialect);

// The refractive index both of OpenSRD's codes are built with; its settings carry none.
inline constexpr double kPublishedIndex = 1.336;
inline constexpr int kMaxCameras = 3;

struct CameraSettings {
  std::filesystem::path calibration;     // .yml
  std::filesystem::path reference;       // image, or pose file when the pose comes from a file
  std::filesystem::path frames;          // folder of images or of feature files
  std::filesystem::path feature_points;  // F, x y z a line; empty in k2017
  std::filesystem::path pose_points;     // empty in kGuide: the board's grid of square_mm
  Region region;                         // px; min_u <= u < max_u, min_v <= v < max_v; k2017
  int position = 1;                      // 1..4; 2 and 3 see the pattern turned by half a turn (guide, appendix A)
  // As the settings name them; empty when they name none.
  std::filesystem::path pose_output;
  std::filesystem::path features_output;
};

// What only the 2017 release has: the pattern-consistency metric on a region of each camera's image.
struct PatchSettings {
  double square_mm = 0;
  int dark_below = 0;  // grey levels
  int bright_above = 0;
  std::filesystem::path centres_output;
};

struct Settings {
  std::filesystem::path file;
  Dialect dialect = Dialect::k2016;
  std::vector<CameraSettings> cameras;  // 1 to 3
  bool pose_from_image = true;
  bool features_from_images = true;
  bool save_pose = true;
  bool save_features = true;
  bool save_errors = true;

  PatternSize board;     // seen in the reference image
  double square_mm = 0;  // of the board; kGuide
  PatternSize pattern;   // of the feature points
  PatchSettings patch;   // k2017

  // k2017: 2, its form with a horizontal surface for the intersection and one slope.
  int parameters = 0;
  double lx = 0, ly = 0;      // mm
  std::vector<double> guess;  // mm, one a parameter: shorter guesses are filled with zeros
  std::vector<double> scale;  // one a parameter

  dsp::Metric metric = dsp::Metric::kDisparity;
  double epsg = 0, epsf = 0, epsx = 0;  // 0: off
  int max_iterations = 0;               // 0: no limit of the settings

  int response_radius = 5;       // px, 5 or 10
  int response_threshold = 350;  // of optics (22)
  double min_distance_px = 15;   // between corners
  double match_radius_px = 10;   // between prediction and corner

  std::filesystem::path coefficients_output;
  std::filesystem::path errors_output;

  // For a person: ignored keys, deprecated or contradictory values.
  std::vector<std::string> warnings;
};

[[nodiscard]] Outcome<Settings> read_settings(const std::filesystem::path& file);

}  // namespace srd::host::opensrd
