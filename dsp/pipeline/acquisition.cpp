// SPDX-License-Identifier: Apache-2.0
// Finding the pattern in a whole image and telling which corner is which: members of SurfaceTracker.
#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/pipeline/surface_tracker.hpp"

namespace srd::dsp {

template <class S>
TrackStatus SurfaceTracker<S>::acquire(PerCamera& camera, const GrayView& image) {
  camera.observations.clear();
  DetectorOptions detector = options_.detector;
  detector.region = camera.setup.region;
  const Result<CornerGrid> largest = camera.finder->find(image, detector);
  camera.track.fit.sharpening = camera.finder->sharpening();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!camera.predictions.valid(i)) continue;
    const Vec2<S>& q = camera.predictions[i].pixel;
    const Region& r = camera.setup.region;
    const auto within = [](S x, int low, int high) { return x >= static_cast<S>(low) && x < static_cast<S>(high); };
    if (r.empty() ? within(q.x(), 0, image.width) && within(q.y(), 0, image.height)
                  : within(q.x(), r.u0, r.u1) && within(q.y(), r.v0, r.v1))
      ++result_.expected;
  }
  if (!largest) return TrackStatus::kNoPattern;
  // The pattern need not be the largest board in view, nor in one piece: the largest grid that fits the prediction.
  TrackStatus status = TrackStatus::kNoPattern;
  for (const CornerGrid& grid : camera.finder->grids()) {
    if (grid.found < std::min(largest->found, options_.min_corners)) break;
    const TrackStatus placed = place(camera, camera.finder->corners(), grid);
    if (placed == TrackStatus::kOk) return placed;
    if (status == TrackStatus::kNoPattern) status = placed;
  }
  return status;
}

// Lays the detected grid on the pattern near where the pattern is predicted. The board repeats itself every second
// square: of the placements within two squares, the one that agrees best with the prediction wins if it explains as many
// corners as any other, and if the runner-up is clearly further off.
template <class S>
TrackStatus SurfaceTracker<S>::place(PerCamera& camera, std::span<const CornerFit> corners, const CornerGrid& grid) {
  // The grid's two steps at its densest place, px.
  Vec2<S> row_step = Vec2<S>::Zero(), column_step = Vec2<S>::Zero(), anchor = Vec2<S>::Zero();
  int row_steps = 0, column_steps = 0, anchor_row = -1, anchor_column = -1;
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
        anchor_row = r;
        anchor_column = c;
        anchor = pixel_of(here);
      }
      if (r + 1 < grid.rows && grid.at(r + 1, c) >= 0) {
        row_step += pixel_of(grid.at(r + 1, c)) - pixel_of(here);
        ++row_steps;
      }
      if (c + 1 < grid.columns && grid.at(r, c + 1) >= 0) {
        column_step += pixel_of(grid.at(r, c + 1)) - pixel_of(here);
        ++column_steps;
      }
    }
  if (row_steps == 0 || column_steps == 0) return TrackStatus::kTooFewCorners;
  row_step /= static_cast<S>(row_steps);
  column_step /= static_cast<S>(column_steps);

  // The predicted point nearest to the anchor, and how the pattern's axes run there.
  int centre = -1;
  S best2 = std::numeric_limits<S>::max();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!camera.predictions.valid(i)) continue;
    const S d2 = (camera.predictions[i].pixel - anchor).squaredNorm();
    if (d2 < best2) {
      best2 = d2;
      centre = static_cast<int>(i);
    }
  }
  if (centre < 0) return TrackStatus::kNoPattern;
  const Mat2<S>& m = camera.predictions[static_cast<std::size_t>(centre)].pixel_per_mm;
  const S square = static_cast<S>(pattern_.square());
  const S det = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  const auto in_squares = [&](const Vec2<S>& step) {
    return Vec2<S>((m(1, 1) * step.x() - m(0, 1) * step.y()) / (det * square),
                   (m(0, 0) * step.y() - m(1, 0) * step.x()) / (det * square));
  };
  const Vec2<S> row_axis = in_squares(row_step), column_axis = in_squares(column_step);
  const auto whole = [](S x) { return static_cast<int>(std::lround(x)); };
  Placement placement{whole(row_axis.x()), whole(column_axis.x()), whole(row_axis.y()), whole(column_axis.y()), 0, 0};
  const int turn =
      placement.row_from_row * placement.column_from_column - placement.row_from_column * placement.column_from_row;
  if (std::abs(turn) != 1) return TrackStatus::kNoPattern;  // the squares have another size than predicted

  constexpr int kReach = 3;  // squares round the prediction
  struct Candidate {
    int count = 0;
    S displacement = 0;
    Placement placement{};
    bool bright_origin = false;
  };
  Candidate best, second;
  for (int dr = -kReach; dr <= kReach; ++dr)
    for (int dc = -kReach; dc <= kReach; ++dc) {
      Candidate c;
      c.placement = placement;
      c.placement.row =
          pattern_.row(centre) + dr - placement.row_from_row * anchor_row - placement.row_from_column * anchor_column;
      c.placement.column =
          pattern_.column(centre) + dc - placement.column_from_row * anchor_row - placement.column_from_column * anchor_column;
      c.count = assign(camera, corners, grid, c.placement, c.bright_origin, c.displacement);
      if (c.count == 0) continue;
      const auto better = [](const Candidate& a, const Candidate& b) {
        return a.count != b.count ? a.count > b.count : a.displacement < b.displacement;
      };
      if (best.count == 0 || better(c, best)) {
        second = best;
        best = c;
      } else if (second.count == 0 || better(c, second)) {
        second = c;
      }
    }
  camera.observations.clear();
  if (best.count < 2) return TrackStatus::kNoPattern;
  // Half-way between two placements the level guess cannot tell them apart.
  if (second.count == best.count && second.displacement < S(1.25) * best.displacement) return TrackStatus::kAmbiguous;
  (void)assign(camera, corners, grid, best.placement, best.bright_origin, best.displacement);
  bright_origin_ = best.bright_origin;
  return TrackStatus::kOk;
}

// Gives every grid corner its point. Returns how many have one with the right polarity (0 when the polarity of the
// majority contradicts what is known); displacement: rms distance from the predictions, px.
template <class S>
int SurfaceTracker<S>::assign(PerCamera& camera, std::span<const CornerFit> corners, const CornerGrid& grid,
                              const Placement& placement, bool& bright_origin, S& displacement) const {
  int count[2] = {0, 0};
  S sum2[2] = {0, 0};
  const auto visit = [&](auto&& act) {
    for (int r = 0; r < grid.rows; ++r)
      for (int c = 0; c < grid.columns; ++c) {
        const int index = grid.at(r, c);
        if (index < 0) continue;
        const int point = pattern_.at(placement.row + placement.row_from_row * r + placement.row_from_column * c,
                                      placement.column + placement.column_from_row * r + placement.column_from_column * c);
        if (point < 0 || !camera.predictions.valid(static_cast<std::size_t>(point))) continue;
        const CornerFit& fit = corners[static_cast<std::size_t>(index)];
        const Prediction<S>& p = camera.predictions[static_cast<std::size_t>(point)];
        act(point, fit, p, is_bright(p, fit.shape) != pattern_.odd(point));
      }
  };
  visit([&](int, const CornerFit& fit, const Prediction<S>& p, bool origin) {
    ++count[origin];
    sum2[origin] += (Vec2<S>(fit.corner.u.template to<S>(), fit.corner.v.template to<S>()) - p.pixel).squaredNorm();
  });
  bright_origin = polarity_known_ ? bright_origin_ : count[1] > count[0];
  const int n = count[bright_origin];
  if (n <= count[!bright_origin]) return 0;
  displacement = std::sqrt(sum2[bright_origin] / static_cast<S>(n));
  camera.observations.clear();
  visit([&](int point, const CornerFit& fit, const Prediction<S>&, bool origin) {
    if (origin != bright_origin || camera.observations.size() == camera.observations.capacity()) return;
    camera.blur_q12[static_cast<std::size_t>(point)] = fit.shape.blur_q12;
    observe(camera, point, fit, Observation<S>().foot);
  });
  return n;
}

template TrackStatus SurfaceTracker<float>::acquire(PerCamera&, const GrayView&);
template TrackStatus SurfaceTracker<double>::acquire(PerCamera&, const GrayView&);
template TrackStatus SurfaceTracker<float>::place(PerCamera&, std::span<const CornerFit>, const CornerGrid&);
template TrackStatus SurfaceTracker<double>::place(PerCamera&, std::span<const CornerFit>, const CornerGrid&);
template int SurfaceTracker<float>::assign(PerCamera&, std::span<const CornerFit>, const CornerGrid&, const Placement&, bool&,
                                           float&) const;
template int SurfaceTracker<double>::assign(PerCamera&, std::span<const CornerFit>, const CornerGrid&, const Placement&, bool&,
                                            double&) const;

}  // namespace srd::dsp
