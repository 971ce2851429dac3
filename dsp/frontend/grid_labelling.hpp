// Which corner is which square's: grows a grid from one corner to its neighbours along the edges that meet there.
// Neighbours alternate in polarity (bright to the right of and below one, dark there at the next), so a corner of
// something else rarely joins. Buffers are sized at construction. One thread per object.
#pragma once

#include <span>
#include <vector>

#include "dsp/core/result.hpp"
#include "dsp/frontend/corner_fit.hpp"

namespace srd::dsp {

// Rows run roughly with image v, columns with image u; (0, 0) is nearest the top left of the image.
struct CornerGrid {
  int rows = 0, columns = 0;
  std::span<const int> cells;  // row-major: index into the corners, -1 where none was found
  int found = 0;
  [[nodiscard]] int at(int row, int column) const { return cells[static_cast<std::size_t>(row * columns + column)]; }
  [[nodiscard]] bool complete() const { return found == rows * columns; }
};

class GridLabeller {
 public:
  explicit GridLabeller(int max_corners);

  // The largest grid found. kNotFound when no two corners belong together; kTooSmall for more corners than announced.
  [[nodiscard]] Result<CornerGrid> label(std::span<const CornerFit> corners);
  // Bright (true) or dark in the sector between the directions +u and +v of a corner: the polarity that alternates.
  [[nodiscard]] static bool bright_below_right(const CornerFit& corner);

 private:
  struct Node {
    float u, v;           // px
    float eu, ev, fu, fv;  // edges: e roughly along +u, f roughly along +v, unit length
    float step_u, step_v;  // length to the next corner, px; 0: not known
    bool bright;
    bool labelled;
    int row, column;
  };
  [[nodiscard]] int grow(std::size_t seed);
  [[nodiscard]] int nearest_along(std::size_t from, int axis, int sign) const;

  std::size_t max_corners_;
  std::vector<Node> nodes_;
  std::vector<int> queue_, best_, cells_;
};

}  // namespace srd::dsp
