// SPDX-License-Identifier: Apache-2.0
// The surface's error against the least possible one (19), for every published model and one to three cameras.
#pragma once

#include <vector>

#include "host/study/corner_study.hpp"

namespace srd::study {

enum class SurfaceSource : std::uint8_t {
  kFeatures,  // true corners with 0.1 px noise
  kImages,    // rendered frames, the whole chain; the bound is at the corners' own measured deviation
};

struct SurfaceRow {
  SurfaceSource source = SurfaceSource::kFeatures;
  int parameters = 0, cameras = 0;
  int draws = 0, surfaces = 0;  // noise draws or frames; those that gave a surface
  double corner_px = 0;         // deviation of a corner per axis
  double surface_mm = 0;        // rms over the pattern
  double bound_mm = 0;
};

// quick: few draws, and images for two models only.
[[nodiscard]] Outcome<std::vector<SurfaceRow>> study_surfaces(bool quick, const Progress& progress);

}  // namespace srd::study
