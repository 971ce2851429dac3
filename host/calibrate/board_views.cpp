// SPDX-License-Identifier: Apache-2.0
#include "host/calibrate/board_views.hpp"

#include <algorithm>

#include "dsp/frontend/board_finder.hpp"
#include "dsp/frontend/noise_threshold.hpp"

namespace srd::host {

namespace {

constexpr int kMaxCorners = 16384;
constexpr int kMinSide = 4;         // corners: a part of a board that is smaller may be anything
constexpr double kMinSigma = 1e-3;  // px: a corner is not known better than its pixels' own places
constexpr double kSigmaUnit = 4096;
constexpr double kAgree = 0.9;  // of a board's corners, on the colour of its first square

// As --board has it: along and across.
std::string grid_text(int rows, int columns) { return std::to_string(columns) + " x " + std::to_string(rows); }

struct Candidate {
  SightedBoard board;
  int corners = 0;  // of the image
  int largest_rows = 0, largest_columns = 0, largest_found = 0;
  bool larger = false;  // a grid with a line of corners more than the board has
  [[nodiscard]] int found() const { return static_cast<int>(board.view.corners.size()); }
};

// Cells of a grid as the board has them. A grid that lies on its side is turned by a quarter, never mirrored: a bend
// keeps its sign.
void take(const dsp::CornerGrid& grid, std::span<const dsp::CornerFit> corners, bool on_its_side, Candidate& into) {
  SightedBoard& board = into.board;
  board.rows = on_its_side ? grid.columns : grid.rows;
  board.columns = on_its_side ? grid.rows : grid.columns;
  board.view.corners.clear();
  std::size_t bright = 0;
  for (int r = 0; r < board.rows; ++r)
    for (int c = 0; c < board.columns; ++c) {
      const int cell = on_its_side ? grid.at(grid.rows - 1 - c, r) : grid.at(r, c);
      if (cell < 0) continue;
      const dsp::CornerFit& fit = corners[static_cast<std::size_t>(cell)];
      // Squares alternate from cell to cell; a quarter turn exchanges the four at a corner.
      if (dsp::GridLabeller::bright_below_right(fit) != (((r + c) % 2 != 0) != on_its_side)) ++bright;
      const dsp::Corner& corner = fit.corner;
      board.view.corners.push_back(
          {r, c, {corner.u.to<double>(), corner.v.to<double>()}, std::max(corner.sigma_q12 / kSigmaUnit, kMinSigma)});
    }
  // Of a board that lies at half a right angle, perspective makes some corners' edges change names.
  const double share = static_cast<double>(bright) / static_cast<double>(std::max<std::size_t>(board.view.corners.size(), 1));
  board.bright_first = share >= kAgree ? std::optional(true) : share <= 1 - kAgree ? std::optional(false) : std::nullopt;
}

bool is_part(int rows, int columns, const bundle::BoardShape& board) {
  return rows >= kMinSide && columns >= kMinSide && rows <= board.rows && columns <= board.columns;
}

// One stray corner does not make a line.
bool is_larger(const dsp::CornerGrid& grid, const bundle::BoardShape& board) {
  const int rows = std::max(grid.rows, grid.columns), columns = std::min(grid.rows, grid.columns);
  const int most = std::max(board.rows, board.columns), least = std::min(board.rows, board.columns);
  return (rows > most || columns > least) && rows >= most && columns >= least && grid.found > board.count() + least * 3 / 4;
}

Candidate search_once(dsp::BoardFinder& finder, const GrayImage& image, const bundle::BoardShape& board,
                      const BoardSearch& search, int threshold) {
  dsp::DetectorOptions options;
  options.response.radius = search.radius;
  options.threshold = threshold;
  options.min_distance = static_cast<int>(search.min_distance);
  Candidate best;
  best.board.threshold = threshold;
  const auto look = [&](bool on_its_side) {
    const int rows = on_its_side ? board.columns : board.rows, columns = on_its_side ? board.rows : board.columns;
    const auto grid = finder.find(image.view(), options, {rows, columns});
    if (!grid) return;
    const auto consider = [&](const dsp::CornerGrid& g) {
      const bool fits = on_its_side ? is_part(g.columns, g.rows, board) : is_part(g.rows, g.columns, board);
      if (fits && g.found > best.found()) take(g, finder.corners(), on_its_side, best);
    };
    consider(*grid);
    for (const dsp::CornerGrid& other : finder.grids()) {
      consider(other);
      best.larger = best.larger || is_larger(other, board);
      if (other.found > best.largest_found) {
        best.largest_found = other.found;
        best.largest_rows = other.rows;
        best.largest_columns = other.columns;
      }
    }
  };
  look(false);
  best.corners = static_cast<int>(finder.corners().size());
  if (board.rows != board.columns && best.found() < board.count()) look(true);
  return best;
}

}  // namespace

Outcome<SightedBoard> sight_board(const GrayImage& image, const std::filesystem::path& file, const bundle::BoardShape& board,
                                  const BoardSearch& search) {
  dsp::BoardFinder finder(image.width, image.height, kMaxCorners);
  const Candidate best =
      search_once(finder, image, board, search, search.threshold > 0 ? search.threshold : dsp::noise_threshold(image.view()));
  if (best.found() == 0 || best.larger) {
    std::string found = std::to_string(best.corners) + " corners, which make no grid";
    if (best.largest_found > 0)
      found = "a grid of " + grid_text(best.largest_rows, best.largest_columns) + " with " +
              std::to_string(best.largest_found) + " corners";
    return Problem{Exit::kInput,
                   best.larger ? "shows a larger board" : "shows no such board",
                   file.string(),
                   "a board of " + grid_text(board.rows, board.columns) + " inner corners, or a part of it of at least " +
                       grid_text(kMinSide, kMinSide),
                   found,
                   "count the inner corners, look at light and focus, and keep other checks out of the image"};
  }
  SightedBoard sighted = best.board;
  sighted.file = file;
  sighted.width = image.width;
  sighted.height = image.height;
  sighted.view.name = file.filename().string();
  return sighted;
}

}  // namespace srd::host
