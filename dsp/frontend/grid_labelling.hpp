// SPDX-License-Identifier: Apache-2.0
// Which corner is which square's: the boards of an image, each a grid of corners in rows and columns.
// Neighbours alternate in polarity (bright to the right of and below one, dark there at the next) and lie where the
// smooth map of those round them says, so a corner of something else rarely joins. Parts of a board that cannot be
// joined for sure are grids of their own. Buffers are sized at construction. One thread per object.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dsp/core/result.hpp"
#include "dsp/frontend/corner_fit.hpp"
#include "dsp/frontend/corner_lattice.hpp"
#include "dsp/frontend/corner_links.hpp"

namespace srd::dsp {

// Rows run roughly with image v, columns with image u; (0, 0) is nearest the top left of the image.
struct CornerGrid {
  int rows = 0, columns = 0;
  std::span<const int> cells;  // row-major: index into the corners, -1 where none was found
  int found = 0;
  // How much better than the next best choice it is (another place of the board on the same corners, another grid),
  // corners that speak for it; near 0: as good as none.
  float lead = 0;
  [[nodiscard]] int at(int row, int column) const { return cells[static_cast<std::size_t>(row * columns + column)]; }
  [[nodiscard]] bool complete() const { return found == rows * columns; }
};

// A corner that a grid expects between at least two others and the image shows, though it was not among the corners: where a
// fit may start.
struct SightedCorner {
  CornerShape shape;
  float step = 0;      // to the next corner of the grid, the shortest way, px
  float contrast = 0;  // the least of those beside it, grey levels from dark to bright
};

// Inner corners of a board.
struct BoardSize {
  int rows = 0, columns = 0;
};

class GridLabeller {
 public:
  explicit GridLabeller(int max_corners);

  // image: which the corners are of, so that the edges between them can be looked at; empty: it is done without.
  // The largest grid found. kNotFound when no four corners make a cell; kTooSmall for more corners than announced.
  [[nodiscard]] Result<CornerGrid> label(std::span<const CornerFit> corners, const GrayView& image = {});
  // The board of this size: where a grid is larger, the part of it that the corners support best. A grid that is smaller
  // than the board one way is given as it is found.
  [[nodiscard]] Result<CornerGrid> label(std::span<const CornerFit> corners, BoardSize board, const GrayView& image = {});
  // All grids of the last label(), the largest first. Valid until the next.
  [[nodiscard]] std::span<const CornerGrid> grids() const { return std::span(grids_).first(grid_count_); }
  // Of the last label(), no more than corners were announced.
  [[nodiscard]] std::span<const SightedCorner> sighted() const { return sighted_; }
  // From a corner of the last label() to the one nearest to it, the median, px; 0: fewer than two corners.
  [[nodiscard]] float usual_gap();
  // Bright (true) or dark in the sector between the directions +u and +v of a corner: the polarity that alternates.
  [[nodiscard]] static bool bright_below_right(const CornerFit& corner);

 private:
  [[nodiscard]] Result<void> find_grids(std::span<const CornerFit> corners, const GrayView& image);
  [[nodiscard]] int turn_of(int piece) const;
  [[nodiscard]] bool lay_out(int piece);
  void weigh(std::span<const CornerFit> corners);
  void list_sighted();

  std::size_t max_corners_;
  CornerLinks links_;
  CornerLattice lattice_;
  std::vector<int> cells_, board_cells_;
  std::vector<float> weight_, sorted_;  // how good a corner is: 1 like most, 0 like none
  std::vector<SightedCorner> sighted_;
  std::array<CornerGrid, CornerLattice::kMaxPieces> grids_{};
  std::size_t grid_count_ = 0;
};

}  // namespace srd::dsp
