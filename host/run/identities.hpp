// SPDX-License-Identifier: Apache-2.0
// Which end of a camera's list of points its corners count from. A camera on the other side of the pattern sees the list
// from its end (guide, appendix A), and a half turn leaves no trace in the residuals: only the pose tells.
#pragma once

#include <span>

#include "host/run/run.hpp"

namespace srd::host {

// A corner by its place in the camera's own list.
struct ListedCorner {
  int place = 0;
  dsp::Vec2<double> normalised;
};

// Seen from the pose, with or without water, the corners lie nearer to the points counted from the end.
[[nodiscard]] bool counts_from_end(std::span<const ListedCorner> corners, const RunCamera& camera, const Points& points);
// The run's point of a place in the camera's own list.
[[nodiscard]] int point_at(const RunCamera& camera, int place, bool from_end);

}  // namespace srd::host
