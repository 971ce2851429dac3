// SPDX-License-Identifier: Apache-2.0
// The surfaces that a scene's frames show, as truth.csv keeps them.
#pragma once

#include "drivers/camera/simulator/scene.hpp"
#include "drivers/recording/truth.hpp"

namespace srd {

// Frames 0 .. frames - 1.
[[nodiscard]] inline Truth truth_of(const Scene& scene, std::uint64_t frames) {
  Truth truth{scene.surface.modes, {}};
  truth.rows.reserve(static_cast<std::size_t>(frames));
  for (std::uint64_t frame = 0; frame < frames; ++frame)
    truth.rows.push_back({frame, scene.time_ns(frame), scene.coefficients(frame)});
  return truth;
}

}  // namespace srd
