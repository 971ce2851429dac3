// SPDX-License-Identifier: Apache-2.0
#include "host/plot/contour.hpp"

#include <array>
#include <map>
#include <utility>

namespace srd::host {
namespace {

// Crossings are named by the grid edge they lie on: 2 (row * columns + column), plus 1 for the edge
// downwards.
using Edge = Eigen::Index;

struct Grid {
  const Eigen::MatrixXd& z;
  double level;

  [[nodiscard]] bool above(Eigen::Index row, Eigen::Index column) const { return z(row, column) >= level; }
  [[nodiscard]] Edge rightwards(Eigen::Index row, Eigen::Index column) const { return 2 * (row * z.cols() + column); }
  [[nodiscard]] Edge downwards(Eigen::Index row, Eigen::Index column) const { return rightwards(row, column) + 1; }
  [[nodiscard]] Place crossing(Edge edge) const {
    const Eigen::Index row = edge / 2 / z.cols(), column = edge / 2 % z.cols();
    const bool down = edge % 2 == 1;
    const double a = z(row, column), b = down ? z(row + 1, column) : z(row, column + 1);
    const double part = (level - a) / (b - a);
    return {static_cast<double>(column) + (down ? 0 : part), static_cast<double>(row) + (down ? part : 0)};
  }
};

// The pieces of the line in one cell, as pairs of edges.
void cell_pieces(const Grid& g, Eigen::Index row, Eigen::Index column, std::vector<std::pair<Edge, Edge>>& pieces) {
  const bool nw = g.above(row, column), ne = g.above(row, column + 1);
  const bool sw = g.above(row + 1, column), se = g.above(row + 1, column + 1);
  const Edge north = g.rightwards(row, column), south = g.rightwards(row + 1, column);
  const Edge west = g.downwards(row, column), east = g.downwards(row, column + 1);
  std::array<Edge, 4> crossed{};
  std::size_t n = 0;
  if (nw != ne) crossed[n++] = north;
  if (ne != se) crossed[n++] = east;
  if (se != sw) crossed[n++] = south;
  if (sw != nw) crossed[n++] = west;
  if (n == 2) pieces.emplace_back(crossed[0], crossed[1]);
  if (n == 4) {
    const double mean = 0.25 * g.z.block(row, column, 2, 2).sum();
    if ((mean >= g.level) == nw) {
      pieces.emplace_back(north, east);
      pieces.emplace_back(south, west);
    } else {
      pieces.emplace_back(north, west);
      pieces.emplace_back(south, east);
    }
  }
}

}  // namespace

std::vector<std::vector<Place>> contour_lines(const Eigen::MatrixXd& heights, double level) {
  const Grid grid{heights, level};
  std::vector<std::pair<Edge, Edge>> pieces;
  for (Eigen::Index row = 0; row + 1 < heights.rows(); ++row)
    for (Eigen::Index column = 0; column + 1 < heights.cols(); ++column) cell_pieces(grid, row, column, pieces);
  std::multimap<Edge, std::size_t> at;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    at.emplace(pieces[i].first, i);
    at.emplace(pieces[i].second, i);
  }
  std::vector<bool> used(pieces.size(), false);
  const auto follow = [&](std::size_t piece, Edge from) {
    std::vector<Place> line{grid.crossing(from)};
    for (Edge edge = from;;) {
      used[piece] = true;
      edge = pieces[piece].first == edge ? pieces[piece].second : pieces[piece].first;
      line.push_back(grid.crossing(edge));
      const auto [begin, end] = at.equal_range(edge);
      auto next = begin;
      while (next != end && used[next->second]) ++next;
      if (next == end) return line;
      piece = next->second;
    }
  };
  std::vector<std::vector<Place>> lines;
  // Open lines from one of their ends, then what is left: closed ones.
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (const Edge edge : {pieces[i].first, pieces[i].second})
      if (!used[i] && at.count(edge) == 1) lines.push_back(follow(i, edge));
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (!used[i]) lines.push_back(follow(i, pieces[i].first));
  return lines;
}

}  // namespace srd::host
