// SPDX-License-Identifier: Apache-2.0
#include "host/pose/board_order.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/support/formatted.hpp"

namespace srd::host {

namespace {

using dsp::Vec2;

// A spot in the first square's middle differs from the square's rim by this part of the board's contrast.
constexpr double kMarkContrast = 0.4;

// One way in which the board may lie in the image: place in the list by cell of the image.
struct Candidate {
  std::vector<int> points;
  std::vector<int> cell_of;  // the inverse
  int quarter_turns = 0;
};

std::vector<Candidate> candidates(PatternSize seen, PatternSize board) {
  std::vector<Candidate> all;
  for (int turns = 0; turns < 4; ++turns) {
    const bool swapped = turns % 2 == 1;
    if (seen.rows != (swapped ? board.columns : board.rows) || seen.columns != (swapped ? board.rows : board.columns)) continue;
    Candidate candidate;
    candidate.quarter_turns = turns;
    candidate.cell_of.resize(static_cast<std::size_t>(board.count()));
    for (int r = 0; r < seen.rows; ++r)
      for (int c = 0; c < seen.columns; ++c) {
        int row = r, column = c;
        if (turns == 1) row = c, column = board.columns - 1 - r;
        if (turns == 2) row = board.rows - 1 - r, column = board.columns - 1 - c;
        if (turns == 3) row = board.rows - 1 - c, column = r;
        const int place = row * board.columns + column;
        candidate.cell_of[static_cast<std::size_t>(place)] = static_cast<int>(candidate.points.size());
        candidate.points.push_back(place);
      }
    all.push_back(std::move(candidate));
  }
  return all;
}

const BoardCorner& corner_at(const ReferenceView& view, const Candidate& candidate, int place) {
  return view.corners[static_cast<std::size_t>(candidate.cell_of[static_cast<std::size_t>(place)])];
}

// Two neighbours of a corner along the board's axes; the pixel of (x, y) squares from it, near enough within two squares.
struct LocalMap {
  Vec2<double> origin, x, y;
  [[nodiscard]] Vec2<double> at(double sx, double sy) const { return origin + sx * x + sy * y; }
};

LocalMap map_at_first(const ReferenceView& view, const Candidate& candidate, PatternSize board) {
  const Vec2<double> origin = corner_at(view, candidate, 0).pixel;
  return {origin, corner_at(view, candidate, board.columns).pixel - origin, corner_at(view, candidate, 1).pixel - origin};
}

double level_round(const GrayView& image, const Vec2<double>& at, double radius) {
  const int reach = std::max(1, static_cast<int>(radius));
  const int u0 = static_cast<int>(std::lround(at.x())), v0 = static_cast<int>(std::lround(at.y()));
  double sum = 0;
  int n = 0;
  for (int v = std::max(0, v0 - reach); v <= std::min(image.height - 1, v0 + reach); ++v)
    for (int u = std::max(0, u0 - reach); u <= std::min(image.width - 1, u0 + reach); ++u, ++n) sum += image.row(v)[u];
  return n > 0 ? sum / n : 0;
}

bool first_is_bright(const ReferenceView& view, const Candidate& candidate, PatternSize board) {
  const LocalMap map = map_at_first(view, candidate, board);
  const Vec2<double> inside = map.x + map.y;
  return corner_at(view, candidate, 0).bright_below_right == (inside.x() * inside.y() > 0);
}

// The square's own grey is that of its rim; the mark is in its middle.
bool first_is_marked(const ReferenceView& view, const Candidate& candidate, PatternSize board) {
  const LocalMap map = map_at_first(view, candidate, board);
  const GrayView image = view.image.view();
  const double side = std::min(map.x.norm(), map.y.norm()), radius = 0.06 * side;
  const auto rim = [&](double x, double y) {
    double sum = 0;
    for (const double dx : {0.2, 0.8})
      for (const double dy : {0.2, 0.8}) sum += level_round(image, map.at(x + dx, y + dy), radius) / 4;
    return sum;
  };
  const double own = rim(0, 0), contrast = std::abs(own - rim(1, 0));
  return std::abs(level_round(image, map.at(0.5, 0.5), radius) - own) > kMarkContrast * contrast;
}

// Whether the list's first square and the world's have different colours.
bool first_is_odd(std::span<const dsp::Vec3<double>> points, PatternSize board) {
  const auto& first = points[0];
  const auto& across = points[static_cast<std::size_t>(board.columns) + 1];
  const double square = (points[1] - first).norm();
  const auto squares = [&](int axis) { return std::lround(std::min(first[axis], across[axis]) / square); };
  return ((squares(0) + squares(1)) & 1) != 0;
}

std::string pixel_text(const Vec2<double>& pixel) { return formatted("%.1f,%.1f", pixel.x(), pixel.y()); }

Outcome<Candidate> nearest_to(const ReferenceView& view, const std::vector<Candidate>& all, const Vec2<double>& pixel,
                              const std::string& where) {
  std::vector<std::pair<double, const Candidate*>> by_distance;
  std::string places;
  for (const Candidate& candidate : all) {
    const Vec2<double>& at = corner_at(view, candidate, 0).pixel;
    by_distance.emplace_back((at - pixel).norm(), &candidate);
    places += (places.empty() ? "" : " or ") + pixel_text(at);
  }
  std::sort(by_distance.begin(), by_distance.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (by_distance.size() > 1 && by_distance[0].first > 0.5 * by_distance[1].first)
    return Problem{Exit::kInput,
                   "--first-corner is near no outer corner of the board, or near two",
                   where,
                   "about where the first point of the pattern is seen: " + places,
                   pixel_text(pixel),
                   "read its place in an image viewer, column and row"};
  return *by_distance[0].second;
}

}  // namespace

Outcome<BoardOrder> order_of(const ReferenceView& view, std::span<const dsp::Vec3<double>> points, PatternSize board,
                             const OrderKnowledge& known, const std::string& where) {
  std::vector<Candidate> all = candidates(view.seen, board);
  if (all.empty() || points.size() != static_cast<std::size_t>(board.count()))
    return Problem{Exit::kInput,
                   "does not show the board of the points",
                   where,
                   formatted("%d rows of %d corners", board.rows, board.columns),
                   formatted("%d rows of %d", view.seen.rows, view.seen.columns),
                   ""};
  const bool tells = known.origin != OriginSquare::kUnknown;
  const bool bright = (known.origin == OriginSquare::kBright) != first_is_odd(points, board);
  const auto agrees = [&](const Candidate& c) { return !tells || first_is_bright(view, c, board) == bright; };
  const auto contradiction = [&](const std::string& what, const std::string& fitting = {}) {
    return Problem{Exit::kInput,
                   what + " contradicts the colours of the squares",
                   where,
                   std::string("a ") + (known.origin == OriginSquare::kBright ? "bright" : "dark") +
                       " square between (0, 0) and (1, 1) squares of the world",
                   known.origin == OriginSquare::kBright ? "a dark one" : "a bright one",
                   fitting + "say --origin-square bright, dark or unknown as it is printed" +
                       (fitting.empty() ? ", or correct the position" : "")};
  };
  if (known.position != 0) {
    const int turns = known.position == 2 || known.position == 3 ? 2 : 0;
    const auto chosen = std::find_if(all.begin(), all.end(), [&](const Candidate& c) { return c.quarter_turns == turns; });
    if (chosen == all.end()) {
      std::string corners;
      for (const Candidate& c : all)
        if (agrees(c)) corners += (corners.empty() ? "" : " or ") + pixel_text(corner_at(view, c, 0).pixel);
      return Problem{
          Exit::kInput,
          "shows the board with its rows upright, as none of the camera positions 1 to 4 sees it",
          where,
          formatted("%d rows of %d corners", board.rows, board.columns),
          formatted("%d rows of %d", view.seen.rows, view.seen.columns),
          "leave --position out" + (corners.empty() ? std::string() : ", or give --first-corner " + corners + " instead")};
    }
    if (!agrees(*chosen)) {
      std::string fitting;
      for (const Candidate& c : all)
        if (c.quarter_turns == 2 - turns && agrees(c))
          fitting = turns == 0 ? "--position 2 or 3, which see the board from its end, fit; or "
                               : "--position 1 or 4, which see the board from its beginning, fit; or ";
      return contradiction(formatted("--position %d", known.position), fitting);
    }
    return BoardOrder{chosen->points, formatted("camera position %d", known.position)};
  }
  if (known.first_corner) {
    const auto chosen = nearest_to(view, all, *known.first_corner, where);
    if (!chosen) return chosen.error();
    if (!agrees(*chosen)) return contradiction("--first-corner " + pixel_text(*known.first_corner));
    return BoardOrder{chosen->points, "the corner pointed at"};
  }
  const auto several = all.size();
  std::erase_if(all, [&](const Candidate& c) { return !agrees(c); });
  if (all.empty()) return contradiction("the board");
  if (all.size() == 1) return BoardOrder{all[0].points, several == 1 ? "the board's shape" : "the colour of the first square"};
  std::vector<Candidate> marked;
  for (const Candidate& c : all)
    if (first_is_marked(view, c, board)) marked.push_back(c);
  if (marked.size() == 1) return BoardOrder{marked[0].points, "the mark in the first square"};
  std::string places;
  for (const Candidate& c : all) places += (places.empty() ? "" : " or ") + pixel_text(corner_at(view, c, 0).pixel);
  return Problem{Exit::kInput,
                 "shows a board that looks alike from several sides",
                 where,
                 "a mark in the square beyond the pattern's first point, or a hint",
                 formatted("%zu ways to lay out %d rows of %d corners", all.size(), board.rows, board.columns),
                 "add --first-corner " + places + ", or --position 1 to 4 (guide, appendix A)"};
}

}  // namespace srd::host
