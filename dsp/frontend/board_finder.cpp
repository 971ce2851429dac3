// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/board_finder.hpp"

#include <algorithm>

namespace srd::dsp {

namespace {

constexpr int kMinDistance = 3;  // px: finer squares than that have no corners to measure
// Of the least distance: corners nearer to each other than this may be those of smaller squares that found room.
constexpr float kCrowded = 1.5f;
constexpr float kLabelledWell = 0.9f;  // of the corners: so many on grids, and no square has been missed

}  // namespace

BoardFinder::BoardFinder(int max_width, int max_height, int max_corners)
    : detector_(max_width, max_height, max_corners), labeller_(max_corners) {}

Result<CornerGrid> BoardFinder::find(const GrayView& image, const DetectorOptions& options) {
  return search(image, options, [&] { return labeller_.label(corners_, image); });
}

Result<CornerGrid> BoardFinder::find(const GrayView& image, const DetectorOptions& options, BoardSize board) {
  return search(image, options, [&] { return labeller_.label(corners_, board, image); });
}

int BoardFinder::labelled() const {
  int n = 0;
  for (const CornerGrid& grid : labeller_.grids()) n += grid.found;
  return n;
}

template <class Label>
Result<CornerGrid> BoardFinder::search(const GrayView& image, const DetectorOptions& options, Label&& label) {
  DetectorOptions now = options;
  const auto look = [&](const DetectorOptions& with) {
    corners_ = detector_.detect(image, with);
    return label();
  };
  Result<CornerGrid> best = look(now);
  int most = labelled();
  while ((now.min_distance + 1) / 2 >= kMinDistance && now.min_distance > kMinDistance) {
    const bool labelled_well = static_cast<float>(most) >= kLabelledWell * static_cast<float>(corners_.size());
    if (labelled_well || labeller_.usual_gap() >= kCrowded * static_cast<float>(now.min_distance)) break;
    const DetectorOptions before = now;
    now.min_distance = (now.min_distance + 1) / 2;
    // A window wider than the corners are apart has more than one in it.
    now.fit.half_window = std::min(now.fit.half_window, now.min_distance);
    Result<CornerGrid> finer = look(now);
    if (labelled() <= most) return look(before);
    best = finer;
    most = labelled();
  }
  return best;
}

}  // namespace srd::dsp
