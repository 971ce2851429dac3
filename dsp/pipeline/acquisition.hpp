// SPDX-License-Identifier: Apache-2.0
// Finds the pattern anywhere in an image and tells which corner is which: grids of corners, and the one placement of a grid
// on the pattern that agrees best with where the pattern is predicted. Sized at construction; no heap afterwards. One
// thread per object.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "dsp/frontend/board_finder.hpp"
#include "dsp/pipeline/pattern.hpp"
#include "dsp/pipeline/predictor.hpp"
#include "dsp/pipeline/track_status.hpp"

namespace srd::dsp {

// A detected corner that has its place on the pattern.
struct PlacedCorner {
  int point = 0;  // of the pattern
  CornerFit fit;
};

template <class S>
class Acquisition {
 public:
  // Of images of this size, px. points: of the pattern.
  Acquisition(int width, int height, int points);

  // predictions: of the pattern's points on the surface to look near. bright_origin: whether the square towards +X +Y of
  // W's origin is bright, where that is known; else the corners tell. min_corners: smaller grids than this are looked at
  // only when there is no larger one.
  // kOk: corners() and bright_origin() hold the answer. Else kNoPattern, kTooFewCorners or kAmbiguous, and no corners.
  [[nodiscard]] TrackStatus find(const GrayView& image, const DetectorOptions& detector, const Pattern& pattern,
                                 const Predictor<S>& predictions, std::optional<bool> bright_origin, int min_corners);

  // Of the last find(); valid until the next.
  [[nodiscard]] std::span<const PlacedCorner> corners() const { return corners_; }
  [[nodiscard]] bool bright_origin() const { return bright_origin_; }
  // Of the camera's image processor, as the last image shows it.
  [[nodiscard]] Sharpening sharpening() const { return finder_->sharpening(); }

 private:
  // What one placement of a grid on the pattern means.
  struct Placement {
    int row_from_row, row_from_column, column_from_row, column_from_column;  // grid axes to pattern axes
    int row, column;                                                         // pattern cell of the grid's (0, 0)
  };
  // The grid at its densest place.
  struct Anchor {
    int row = -1, column = -1;
    Vec2<S> pixel = Vec2<S>::Zero();
    Vec2<S> row_step = Vec2<S>::Zero(), column_step = Vec2<S>::Zero();  // px
  };
  struct Candidate {
    int count = 0;       // grid corners that have a point with the right polarity
    S displacement = 0;  // rms distance from the predictions, px
    bool bright_origin = false;
    Placement placement{};
  };
  // The search of one image; borrowed for a find().
  struct Search {
    const Pattern& pattern;
    const Predictor<S>& predictions;
    std::optional<bool> bright_origin;
  };

  [[nodiscard]] TrackStatus place(const Search& search, const CornerGrid& grid);
  [[nodiscard]] bool find_anchor(const CornerGrid& grid, Anchor& out) const;
  // The grid's axes in the pattern's; the pattern cell is left open. False: the squares have another size than predicted.
  [[nodiscard]] bool orient(const Search& search, const Anchor& anchor, int centre, Placement& out) const;
  // Counts for a placement; a count of 0 when the polarity of the majority contradicts what is known.
  [[nodiscard]] Candidate weigh(const Search& search, const CornerGrid& grid, const Placement& placement) const;
  void take(const Search& search, const CornerGrid& grid, const Candidate& chosen);
  // act(point, fit, prediction, bright origin): of every grid corner that falls on a predicted point.
  template <class Act>
  void visit(const Search& search, const CornerGrid& grid, const Placement& placement, Act act) const;

  std::unique_ptr<BoardFinder> finder_;
  std::vector<PlacedCorner> corners_;
  bool bright_origin_ = false;
};

extern template class Acquisition<float>;
extern template class Acquisition<double>;

}  // namespace srd::dsp
