// SPDX-License-Identifier: Apache-2.0
// Was the zoom or the focus changed among the views? The focal length before and behind every place in their order, compared.
#pragma once

#include <optional>
#include <span>

#include "host/bundle/camera_solve.hpp"

namespace srd::bundle {

struct ZoomChange {
  std::size_t from = 0;              // place in the order of the first view with the other focal length
  double part = 0;                   // how much longer it is there, of the focal length
  double deviation = 0;              // standard error of part
  double chi_square = 0, limit = 0;  // of part, one degree; what the most significant place exceeds by chance once in 1000 sets
  [[nodiscard]] bool found() const { return chi_square > limit; }
};

// order: the views as they were taken, indices. The most significant place with at least 3 views on each side; nothing with
// fewer than 6 views. Optics (31a): a step on from the fit, so the change is good to its own square; its error is by the
// corners' deviations or by the views' own scatter, the larger one.
[[nodiscard]] std::optional<ZoomChange> find_zoom_change(const BoardShape& shape, const std::vector<BoardView>& views,
                                                         const CameraFit& fit, std::span<const std::size_t> order);

}  // namespace srd::bundle
