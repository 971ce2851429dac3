// SPDX-License-Identifier: Apache-2.0
#include "dsp/pipeline/acquisition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace srd::dsp {

namespace {
constexpr int kMaxDetections = 4000;
constexpr int kPlacementReach = 3;  // squares round the prediction
}  // namespace

template <class S>
Acquisition<S>::Acquisition(int width, int height, int points)
    : finder_(std::make_unique<BoardFinder>(width, height, kMaxDetections)) {
  corners_.reserve(static_cast<std::size_t>(points));
}

template <class S>
TrackStatus Acquisition<S>::find(const GrayView& image, const DetectorOptions& detector, const Pattern& pattern,
                                 const Predictor<S>& predictions, std::optional<bool> bright_origin, int min_corners) {
  corners_.clear();
  const Result<CornerGrid> largest = finder_->find(image, detector);
  if (!largest) return TrackStatus::kNoPattern;
  // The pattern need not be the largest board in view, nor in one piece: the largest grid that fits the prediction.
  const Search search{pattern, predictions, bright_origin};
  TrackStatus status = TrackStatus::kNoPattern;
  for (const CornerGrid& grid : finder_->grids()) {
    if (grid.found < std::min(largest->found, min_corners)) break;
    const TrackStatus placed = place(search, grid);
    if (placed == TrackStatus::kOk) return placed;
    if (status == TrackStatus::kNoPattern) status = placed;
  }
  return status;
}

// Lays the detected grid on the pattern near where the pattern is predicted. The board repeats itself every second
// square: of the placements within a few squares, the one that agrees best with the prediction wins if it explains as many
// corners as any other, and if the runner-up is clearly further off.
template <class S>
TrackStatus Acquisition<S>::place(const Search& search, const CornerGrid& grid) {
  Anchor anchor;
  if (!find_anchor(grid, anchor)) return TrackStatus::kTooFewCorners;
  // The predicted point nearest to the anchor.
  int centre = -1;
  S best2 = std::numeric_limits<S>::max();
  for (int i = 0; i < search.pattern.size(); ++i) {
    const auto point = static_cast<std::size_t>(i);
    if (!search.predictions.valid(point)) continue;
    const S d2 = (search.predictions[point].pixel - anchor.pixel).squaredNorm();
    if (d2 < best2) {
      best2 = d2;
      centre = i;
    }
  }
  Placement placement{};
  if (centre < 0 || !orient(search, anchor, centre, placement)) return TrackStatus::kNoPattern;

  const auto better = [](const Candidate& a, const Candidate& b) {
    return a.count != b.count ? a.count > b.count : a.displacement < b.displacement;
  };
  Candidate best, second;
  for (int dr = -kPlacementReach; dr <= kPlacementReach; ++dr)
    for (int dc = -kPlacementReach; dc <= kPlacementReach; ++dc) {
      placement.row =
          search.pattern.row(centre) + dr - placement.row_from_row * anchor.row - placement.row_from_column * anchor.column;
      placement.column = search.pattern.column(centre) + dc - placement.column_from_row * anchor.row -
                         placement.column_from_column * anchor.column;
      const Candidate c = weigh(search, grid, placement);
      if (c.count == 0) continue;
      if (best.count == 0 || better(c, best)) {
        second = best;
        best = c;
      } else if (second.count == 0 || better(c, second)) {
        second = c;
      }
    }
  if (best.count < 2) return TrackStatus::kNoPattern;
  // Half-way between two placements the level guess cannot tell them apart.
  if (second.count == best.count && second.displacement < S(1.25) * best.displacement) return TrackStatus::kAmbiguous;
  take(search, grid, best);
  return TrackStatus::kOk;
}

template <class S>
bool Acquisition<S>::find_anchor(const CornerGrid& grid, Anchor& out) const {
  int row_steps = 0, column_steps = 0;
  const std::span<const CornerFit> corners = finder_->corners();
  const auto pixel_of = [&](int index) {
    const Corner& c = corners[static_cast<std::size_t>(index)].corner;
    return Vec2<S>(c.u.template to<S>(), c.v.template to<S>());
  };
  S nearest = std::numeric_limits<S>::max();
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c) {
      const int here = grid.at(r, c);
      if (here < 0) continue;
      // Nearest to the middle of the grid.
      const S off = std::hypot(static_cast<S>(2 * r - grid.rows + 1), static_cast<S>(2 * c - grid.columns + 1));
      if (off < nearest) {
        nearest = off;
        out.row = r;
        out.column = c;
        out.pixel = pixel_of(here);
      }
      if (r + 1 < grid.rows && grid.at(r + 1, c) >= 0) {
        out.row_step += pixel_of(grid.at(r + 1, c)) - pixel_of(here);
        ++row_steps;
      }
      if (c + 1 < grid.columns && grid.at(r, c + 1) >= 0) {
        out.column_step += pixel_of(grid.at(r, c + 1)) - pixel_of(here);
        ++column_steps;
      }
    }
  if (row_steps == 0 || column_steps == 0) return false;
  out.row_step /= static_cast<S>(row_steps);
  out.column_step /= static_cast<S>(column_steps);
  return true;
}

template <class S>
bool Acquisition<S>::orient(const Search& search, const Anchor& anchor, int centre, Placement& out) const {
  const Mat2<S>& m = search.predictions[static_cast<std::size_t>(centre)].pixel_per_mm;
  const S square = static_cast<S>(search.pattern.square());
  const S det = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  const auto in_squares = [&](const Vec2<S>& step) {
    return Vec2<S>((m(1, 1) * step.x() - m(0, 1) * step.y()) / (det * square),
                   (m(0, 0) * step.y() - m(1, 0) * step.x()) / (det * square));
  };
  const Vec2<S> row_axis = in_squares(anchor.row_step), column_axis = in_squares(anchor.column_step);
  const auto whole = [](S x) { return static_cast<int>(std::lround(x)); };
  out = {whole(row_axis.x()), whole(column_axis.x()), whole(row_axis.y()), whole(column_axis.y()), 0, 0};
  const int turn = out.row_from_row * out.column_from_column - out.row_from_column * out.column_from_row;
  return std::abs(turn) == 1;
}

template <class S>
template <class Act>
void Acquisition<S>::visit(const Search& search, const CornerGrid& grid, const Placement& placement, Act act) const {
  const std::span<const CornerFit> corners = finder_->corners();
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c) {
      const int index = grid.at(r, c);
      if (index < 0) continue;
      const int point = search.pattern.at(placement.row + placement.row_from_row * r + placement.row_from_column * c,
                                          placement.column + placement.column_from_row * r + placement.column_from_column * c);
      if (point < 0 || !search.predictions.valid(static_cast<std::size_t>(point))) continue;
      const CornerFit& fit = corners[static_cast<std::size_t>(index)];
      const Prediction<S>& p = search.predictions[static_cast<std::size_t>(point)];
      act(point, fit, p, is_bright(p, fit.shape) != search.pattern.odd(point));
    }
}

template <class S>
typename Acquisition<S>::Candidate Acquisition<S>::weigh(const Search& search, const CornerGrid& grid,
                                                         const Placement& placement) const {
  int count[2] = {0, 0};
  S sum2[2] = {0, 0};
  visit(search, grid, placement, [&](int, const CornerFit& fit, const Prediction<S>& p, bool origin) {
    ++count[origin];
    sum2[origin] += (Vec2<S>(fit.corner.u.template to<S>(), fit.corner.v.template to<S>()) - p.pixel).squaredNorm();
  });
  Candidate out;
  out.placement = placement;
  out.bright_origin = search.bright_origin.value_or(count[1] > count[0]);
  const int n = count[out.bright_origin];
  if (n <= count[!out.bright_origin]) return out;
  out.count = n;
  out.displacement = std::sqrt(sum2[out.bright_origin] / static_cast<S>(n));
  return out;
}

template <class S>
void Acquisition<S>::take(const Search& search, const CornerGrid& grid, const Candidate& chosen) {
  bright_origin_ = chosen.bright_origin;
  visit(search, grid, chosen.placement, [&](int point, const CornerFit& fit, const Prediction<S>&, bool origin) {
    if (origin == bright_origin_ && corners_.size() < corners_.capacity()) corners_.push_back({point, fit});
  });
}

template class Acquisition<float>;
template class Acquisition<double>;

}  // namespace srd::dsp
