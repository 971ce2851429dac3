// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/grid_labelling.hpp"

#include <algorithm>
#include <cmath>

namespace srd::dsp {

namespace {

constexpr std::size_t kMaxCells = 4;  // of a grid, a corner announced: more is mostly holes
// A corner left out of the board speaks against it by half of what one in it speaks for it.
constexpr float kLeftOut = 0.5f;

}  // namespace

GridLabeller::GridLabeller(int max_corners)
    : max_corners_(static_cast<std::size_t>(max_corners)), links_(max_corners_), lattice_(max_corners_) {
  cells_.reserve(kMaxCells * max_corners_);
  board_cells_.reserve(kMaxCells * max_corners_);
  weight_.reserve(max_corners_);
  sorted_.reserve(max_corners_);
  sighted_.reserve(max_corners_);
}

bool GridLabeller::bright_below_right(const CornerFit& corner) { return node_of(corner).bright; }

float GridLabeller::usual_gap() {
  sorted_.clear();
  for (std::size_t i = 0; i < lattice_.places().size(); ++i)
    if (const float gap = links_.gap(i); gap > 0) sorted_.push_back(gap);
  if (sorted_.empty()) return 0;
  const auto half = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), half, sorted_.end());
  return *half;
}

Result<CornerGrid> GridLabeller::label(std::span<const CornerFit> corners, const GrayView& image) {
  if (const Result<void> found = find_grids(corners, image); !found) return found.error();
  CornerGrid& best = grids_[0];
  best.lead = static_cast<float>(best.found - (grid_count_ > 1 ? grids_[1].found : 0));
  return best;
}

Result<CornerGrid> GridLabeller::label(std::span<const CornerFit> corners, BoardSize board, const GrayView& image) {
  if (const Result<void> found = find_grids(corners, image); !found) return found.error();
  weigh(corners);
  struct Choice {
    std::size_t grid = 0;
    int row = 0, column = 0;
    float score = 0;
  };
  Choice best, second;
  bool chosen = false;
  second.score = 0;
  for (std::size_t g = 0; g < grid_count_; ++g) {
    const CornerGrid& grid = grids_[g];
    if (grid.rows < board.rows || grid.columns < board.columns) continue;
    float all = 0;
    for (const int cell : grid.cells)
      if (cell >= 0) all += weight_[static_cast<std::size_t>(cell)];
    for (int row = 0; row + board.rows <= grid.rows; ++row)
      for (int column = 0; column + board.columns <= grid.columns; ++column) {
        float inside = 0;
        for (int r = row; r < row + board.rows; ++r)
          for (int c = column; c < column + board.columns; ++c)
            if (const int cell = grid.at(r, c); cell >= 0) inside += weight_[static_cast<std::size_t>(cell)];
        const Choice choice{g, row, column, inside - kLeftOut * (all - inside)};
        if (!chosen || choice.score > best.score) {
          if (chosen) second = best;
          best = choice;
          chosen = true;
        } else if (choice.score > second.score) {
          second = choice;
        }
      }
  }
  if (!chosen) return grids_[0];
  const CornerGrid& grid = grids_[best.grid];
  board_cells_.clear();
  CornerGrid exact;
  exact.rows = board.rows;
  exact.columns = board.columns;
  exact.lead = best.score - second.score;
  for (int r = 0; r < board.rows; ++r)
    for (int c = 0; c < board.columns; ++c) {
      board_cells_.push_back(grid.at(best.row + r, best.column + c));
      if (board_cells_.back() >= 0) ++exact.found;
    }
  exact.cells = board_cells_;
  return exact;
}

Result<void> GridLabeller::find_grids(std::span<const CornerFit> corners, const GrayView& image) {
  grid_count_ = 0;
  cells_.clear();
  sighted_.clear();
  if (corners.size() > max_corners_) return Errc::kTooSmall;
  links_.build(corners, image);
  lattice_.build(links_);
  list_sighted();
  std::array<int, CornerLattice::kMaxPieces> order{};
  const auto count = static_cast<std::size_t>(lattice_.pieces());
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<int>(i);
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
            [&](int a, int b) { return lattice_.size(a) != lattice_.size(b) ? lattice_.size(a) > lattice_.size(b) : a < b; });
  bool holes = false;
  for (std::size_t i = 0; i < count && lattice_.size(order[i]) > 0; ++i) holes = !lay_out(order[i]) || holes;
  if (grid_count_ == 0) return holes ? Errc::kAmbiguous : Errc::kNotFound;
  return {};
}

void GridLabeller::list_sighted() {
  const std::span<const CornerNode> nodes = links_.nodes();
  for (std::size_t i = lattice_.places().size(); i < nodes.size(); ++i) {
    SightedCorner corner;
    if (lattice_.beside(i, corner.step, corner.contrast) < 2) continue;
    const CornerNode& node = nodes[i];
    // Both half edges lie clockwise of the normals that are a quarter turn back: between them the distances' signs differ.
    const auto normal = [&](std::size_t half, float sign) {
      constexpr float kOne = 16384;
      return Direction{static_cast<std::int32_t>(sign * kOne * node.along[half][1]),
                       static_cast<std::int32_t>(-sign * kOne * node.along[half][0])};
    };
    corner.shape.u = Pixel::from_raw(static_cast<std::int32_t>(node.u * static_cast<float>(Pixel::kOne)));
    corner.shape.v = Pixel::from_raw(static_cast<std::int32_t>(node.v * static_cast<float>(Pixel::kOne)));
    corner.shape.n1 = normal(0, 1);
    corner.shape.n2 = normal(1, node.bright ? -1.0f : 1.0f);
    sighted_.push_back(corner);
  }
}

// Quarter turns after which the piece's columns run nearest to +u.
int GridLabeller::turn_of(int piece) const {
  const std::span<const CornerLattice::Place> places = lattice_.places();
  float u = 0, v = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].piece != piece) continue;
    const CornerNode& node = links_.nodes()[i];
    const auto turn = static_cast<std::size_t>(places[i].turn);
    // The sum of both edges: half a right angle off the columns, and free of the edges' own skew.
    u += node.along[turn][0] + node.along[(turn + 1) % 4][0];
    v += node.along[turn][1] + node.along[(turn + 1) % 4][1];
  }
  // Without a turn it points into the right lower quarter of the image; each turn moves the columns on to the next.
  const bool right = u >= 0, below = v >= 0;
  return right ? (below ? 0 : 3) : (below ? 1 : 2);
}

// The piece as a grid. False: no room, it is mostly holes.
bool GridLabeller::lay_out(int piece) {
  const std::span<const CornerLattice::Place> places = lattice_.places();
  const int turn = turn_of(piece);
  int row0 = 0, row1 = 0, column0 = 0, column1 = 0;
  bool first = true;
  const auto cell_of = [&](const CornerLattice::Place& place) {
    int row = place.row, column = place.column;
    turn_cell(turn, row, column);
    return std::pair{row, column};
  };
  for (const CornerLattice::Place& place : places) {
    if (place.piece != piece) continue;
    const auto [row, column] = cell_of(place);
    row0 = first ? row : std::min(row0, row);
    row1 = first ? row : std::max(row1, row);
    column0 = first ? column : std::min(column0, column);
    column1 = first ? column : std::max(column1, column);
    first = false;
  }
  CornerGrid& grid = grids_[grid_count_];
  grid = {};
  grid.rows = row1 - row0 + 1;
  grid.columns = column1 - column0 + 1;
  const std::size_t start = cells_.size();
  const std::size_t room = static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.columns);
  if (room > cells_.capacity() - start) return false;
  cells_.resize(start + room, -1);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].piece != piece) continue;
    const auto [row, column] = cell_of(places[i]);
    cells_[start + static_cast<std::size_t>((row - row0) * grid.columns + column - column0)] = static_cast<int>(i);
    ++grid.found;
  }
  grid.cells = std::span(cells_).subspan(start, room);
  ++grid_count_;
  return true;
}

// Against the usual corner of the grids: a worse fit, less contrast, off the smooth map.
void GridLabeller::weigh(std::span<const CornerFit> corners) {
  weight_.assign(corners.size(), 0);
  const auto middle = [&](auto&& value) {
    sorted_.clear();
    for (std::size_t i = 0; i < corners.size(); ++i)
      if (lattice_.places()[i].piece >= 0) sorted_.push_back(value(corners[i]));
    const auto half = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
    std::nth_element(sorted_.begin(), half, sorted_.end());
    return *half;
  };
  const auto contrast_of = [](const CornerFit& fit) { return static_cast<float>(std::max<int>(fit.corner.contrast, 1)); };
  const auto residual_of = [&](const CornerFit& fit) {
    return (static_cast<float>(fit.residual_q6) / 64 + 1) / contrast_of(fit);
  };
  const float contrast = middle(contrast_of), residual = middle(residual_of);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (lattice_.places()[i].piece < 0) continue;
    const float faint = std::min(1.0f, 2 * contrast_of(corners[i]) / contrast);
    const float poor = residual_of(corners[i]) / (4 * residual), off = lattice_.misfit(i);
    weight_[i] = faint / (1 + poor * poor + off * off);
  }
}

}  // namespace srd::dsp
