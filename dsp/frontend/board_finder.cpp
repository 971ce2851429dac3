// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/board_finder.hpp"

#include <algorithm>

#include "dsp/frontend/corner_window.hpp"

namespace srd::dsp {

namespace {

constexpr int kMinDistance = 3;  // px: finer squares than that have no corners to measure
// Of the least distance: corners nearer to each other than this may be those of smaller squares that found room.
constexpr float kCrowded = 1.5f;
// Of a corner below the threshold: it must be as clear as those beside it, for their word brought it in.
constexpr int kResidualPercent = 15;
constexpr float kOfContrast = 0.5f;
constexpr float kTravel = 0.25f;       // steps, from where a corner was sighted to where it is fitted
constexpr float kLabelledWell = 0.9f;  // of the corners: so many on grids, and no square has been missed

}  // namespace

BoardFinder::BoardFinder(int max_width, int max_height, int max_corners)
    : max_corners_(static_cast<std::size_t>(max_corners)),
      detector_(max_width, max_height, max_corners),
      labeller_(max_corners) {
  corners_.reserve(max_corners_);
}

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

// False: there is none to be had.
bool BoardFinder::fit_sighted(const GrayView& image, const DetectorOptions& options) {
  const std::size_t before = corners_.size();
  CornerFitOptions fit_options = options.fit;
  fit_options.sharpening = detector_.sharpening();
  for (const SightedCorner& sighted : labeller_.sighted()) {
    if (corners_.size() == max_corners_) break;
    // The window must have no other corner in it.
    const int half_window = std::min(fit_options.half_window, static_cast<int>(sighted.step / 2));
    if (half_window < kMinHalfWindow) continue;
    CornerFitOptions here = fit_options;
    here.half_window = half_window;
    here.max_travel_q12 = std::min(here.max_travel_q12, static_cast<std::int32_t>(kTravel * 4096 * sighted.step));
    CornerFit fit;
    here.max_residual_percent = std::min(here.max_residual_percent, kResidualPercent);
    if (!fit_corner(image, sighted.shape, here, fit)) continue;
    if (2 * static_cast<float>(fit.corner.contrast) < kOfContrast * sighted.contrast) continue;
    const int u = fit.corner.u.round(), v = fit.corner.v.round();
    if (!image.contains(u, v, options.response.radius)) continue;
    fit.corner.response = response_at(image, u, v, options.response);
    corners_.push_back(fit);
  }
  return corners_.size() > before;
}

template <class Label>
Result<CornerGrid> BoardFinder::search(const GrayView& image, const DetectorOptions& options, Label&& label) {
  DetectorOptions now = options;
  const auto look = [&](const DetectorOptions& with) {
    const std::span<const CornerFit> detected = detector_.detect(image, with);
    corners_.assign(detected.begin(), detected.end());
    Result<CornerGrid> found = label();
    return fit_sighted(image, with) ? label() : found;
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
