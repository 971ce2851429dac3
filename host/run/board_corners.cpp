// SPDX-License-Identifier: Apache-2.0
#include "host/run/board_corners.hpp"

#include "dsp/frontend/board_finder.hpp"

namespace srd::host {

namespace {

constexpr int kMaxCorners = 16384;
constexpr double kUnknownSigma = 0.1;  // px; of a corner whose deviation the fit does not tell

std::string grid_text(int rows, int columns) { return std::to_string(rows) + " rows of " + std::to_string(columns); }

}  // namespace

Outcome<std::vector<BoardCorner>> find_board_corners(const GrayView& image, PatternSize board, const CornerSearch& search,
                                                     const std::string& where) {
  dsp::DetectorOptions options;
  options.response.radius = search.radius;
  options.threshold = search.threshold;
  options.min_distance = static_cast<int>(search.min_distance);
  dsp::BoardFinder finder(image.width, image.height, kMaxCorners);
  const Result<dsp::CornerGrid> grid = finder.find(image, options, {board.rows, board.columns});
  const std::span<const dsp::CornerFit> corners = finder.corners();
  const std::string expected = "a board of " + grid_text(board.rows, board.columns) + " inner corners (" +
                               std::to_string(board.count()) + "), whole in the image";
  const std::string advice = "look at the image, at the board's size, and at ResponseThreshold and MinDistance";
  if (!grid)
    return Problem{
        Exit::kInput, "shows no board", where, expected, std::to_string(corners.size()) + " corners, which make no grid",
        advice};
  const bool fits = grid->rows == board.rows && grid->columns == board.columns;
  if (!fits || !grid->complete())
    return Problem{Exit::kInput,
                   "does not show the whole board",
                   where,
                   expected,
                   std::to_string(corners.size()) + " corners; the largest grid has " + grid_text(grid->rows, grid->columns) +
                       " with " + std::to_string(grid->found) + " corners",
                   grid->rows == board.columns && grid->columns == board.rows && grid->complete()
                       ? "the board lies the other way: exchange its width and height"
                       : advice};
  std::vector<BoardCorner> found;
  for (const int cell : grid->cells) {
    const dsp::CornerFit& corner = corners[static_cast<std::size_t>(cell)];
    found.push_back({{corner.corner.u.to<double>(), corner.corner.v.to<double>()},
                     dsp::GridLabeller::bright_below_right(corner),
                     corner.corner.sigma_q12 > 0 ? corner.corner.sigma_q12 / 4096.0 : kUnknownSigma});
  }
  return found;
}

}  // namespace srd::host
