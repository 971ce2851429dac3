// SPDX-License-Identifier: Apache-2.0
// Smallest rectangle round the pattern's corners, mm, in W.
#pragma once

#include <algorithm>

namespace srd::host {

struct PatternExtent {
  double x_min = 0, x_max = 0, y_min = 0, y_max = 0;
  [[nodiscard]] double x_centre() const { return 0.5 * (x_min + x_max); }
  [[nodiscard]] double y_centre() const { return 0.5 * (y_min + y_max); }
  friend bool operator==(const PatternExtent&, const PatternExtent&) = default;
};

// points: at least one, with x() and y().
template <class List>
[[nodiscard]] PatternExtent extent_of(const List& points) {
  PatternExtent e{points[0].x(), points[0].x(), points[0].y(), points[0].y()};
  for (const auto& p : points) {
    e.x_min = std::min(e.x_min, p.x());
    e.x_max = std::max(e.x_max, p.x());
    e.y_min = std::min(e.y_min, p.y());
    e.y_max = std::max(e.y_max, p.y());
  }
  return e;
}

}  // namespace srd::host
