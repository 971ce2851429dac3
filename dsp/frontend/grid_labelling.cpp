#include "dsp/frontend/grid_labelling.hpp"

#include <algorithm>
#include <cmath>

namespace srd::dsp {

namespace {

constexpr float kCone = 0.30f;      // sideways against forward distance of a neighbour, no step known yet
constexpr float kTolerance = 0.33f;  // of a step: how far a neighbour may lie from where it is expected

struct Edges {
  float eu, ev, fu, fv;
};

// Unit vectors along the two edges: the one nearer to the u axis turned to +u, the other to +v.
Edges edges_of(const CornerShape& shape) {
  const auto along = [](const Direction& n) {
    return std::pair{static_cast<float>(-n.y) / 16384.0f, static_cast<float>(n.x) / 16384.0f};
  };
  auto a = along(shape.n1), b = along(shape.n2);
  if (std::abs(a.first) < std::abs(b.first)) std::swap(a, b);
  if (a.first < 0) a = {-a.first, -a.second};
  if (b.second < 0) b = {-b.first, -b.second};
  return {a.first, a.second, b.first, b.second};
}

}  // namespace

GridLabeller::GridLabeller(int max_corners) : max_corners_(static_cast<std::size_t>(max_corners)) {
  nodes_.reserve(max_corners_);
  queue_.reserve(max_corners_);
  best_.reserve(max_corners_);
  cells_.reserve(4 * max_corners_);
}

bool GridLabeller::bright_below_right(const CornerFit& corner) {
  const Edges e = edges_of(corner.shape);
  const float u = e.eu + e.fu, v = e.ev + e.fv;
  const auto side = [&](const Direction& n) {
    return static_cast<float>(n.x) * u + static_cast<float>(n.y) * v > 0;
  };
  return side(corner.shape.n1) == side(corner.shape.n2);
}

Result<CornerGrid> GridLabeller::label(std::span<const CornerFit> corners) {
  if (corners.size() > max_corners_) return Errc::kTooSmall;
  nodes_.clear();
  for (const CornerFit& corner : corners) {
    const Edges e = edges_of(corner.shape);
    nodes_.push_back({corner.corner.u.to<float>(), corner.corner.v.to<float>(), e.eu, e.ev, e.fu, e.fv, 0, 0,
                      bright_below_right(corner), false, 0, 0});
  }
  // A false corner may be a poor seed, so several are tried; a grid of more than half of the corners is the one.
  constexpr std::size_t kSeeds = 24;
  int best = 0;
  std::size_t tried = 0;
  best_.clear();
  const std::size_t stride = std::max<std::size_t>(1, nodes_.size() / kSeeds);
  for (std::size_t i = 0; i < nodes_.size() && tried < kSeeds; i += stride, ++tried) {
    for (Node& node : nodes_) node.labelled = false;
    const int found = grow(i);
    if (found > best) {
      best = found;
      best_.assign(queue_.begin(), queue_.end());
      // queue_ lists the members; keep their labels by re-growing only if a later seed spoils them.
      if (2 * static_cast<std::size_t>(found) > nodes_.size()) break;
    }
  }
  if (best < 2) return Errc::kNotFound;
  for (Node& node : nodes_) node.labelled = false;
  (void)grow(static_cast<std::size_t>(best_.front()));
  int row0 = 0, row1 = 0, column0 = 0, column1 = 0;
  for (const int i : queue_) {
    const Node& node = nodes_[static_cast<std::size_t>(i)];
    row0 = std::min(row0, node.row);
    row1 = std::max(row1, node.row);
    column0 = std::min(column0, node.column);
    column1 = std::max(column1, node.column);
  }
  CornerGrid grid;
  grid.rows = row1 - row0 + 1;
  grid.columns = column1 - column0 + 1;
  const std::size_t cells = static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.columns);
  if (cells > cells_.capacity()) return Errc::kAmbiguous;  // mostly holes: no board
  cells_.assign(cells, -1);
  for (const int i : queue_) {
    const Node& node = nodes_[static_cast<std::size_t>(i)];
    int& cell = cells_[static_cast<std::size_t>((node.row - row0) * grid.columns + node.column - column0)];
    if (cell < 0) ++grid.found;
    cell = i;
  }
  grid.cells = cells_;
  return grid;
}

// Breadth first from the seed; returns how many corners joined. queue_ holds them in the order of joining.
int GridLabeller::grow(std::size_t seed) {
  queue_.clear();
  queue_.push_back(static_cast<int>(seed));
  nodes_[seed].labelled = true;
  nodes_[seed].row = nodes_[seed].column = 0;
  nodes_[seed].step_u = nodes_[seed].step_v = 0;
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const std::size_t from = static_cast<std::size_t>(queue_[head]);
    for (const int axis : {0, 1})
      for (const int sign : {1, -1}) {
        const int next = nearest_along(from, axis, sign);
        if (next < 0) continue;
        Node& a = nodes_[from];
        Node& b = nodes_[static_cast<std::size_t>(next)];
        const float step = std::hypot(b.u - a.u, b.v - a.v);
        (axis == 0 ? a.step_u : a.step_v) = step;
        b.step_u = axis == 0 ? step : a.step_u;
        b.step_v = axis == 1 ? step : a.step_v;
        b.labelled = true;
        b.row = a.row + (axis == 1 ? sign : 0);
        b.column = a.column + (axis == 0 ? sign : 0);
        queue_.push_back(next);
      }
  }
  return static_cast<int>(queue_.size());
}

// The unlabelled neighbour one step along an edge (axis 0: e, 1: f), of the other polarity; -1: none.
int GridLabeller::nearest_along(std::size_t from, int axis, int sign) const {
  const Node& a = nodes_[from];
  const float du = static_cast<float>(sign) * (axis == 0 ? a.eu : a.fu);
  const float dv = static_cast<float>(sign) * (axis == 0 ? a.ev : a.fv);
  const float step = axis == 0 ? a.step_u : a.step_v;
  int best = -1;
  float best_distance = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& b = nodes_[i];
    if (i == from) continue;
    const float u = b.u - a.u, v = b.v - a.v;
    const float forward = u * du + v * dv, sideways = std::abs(u * dv - v * du);
    float distance = forward;
    if (step > 0) {
      distance = std::hypot(forward - step, sideways);
      if (distance > kTolerance * step) continue;
    } else if (forward <= 0 || sideways > kCone * forward) {
      continue;
    }
    if (best < 0 || distance < best_distance) {
      best = static_cast<int>(i);
      best_distance = distance;
    }
  }
  if (best < 0) return -1;
  const Node& b = nodes_[static_cast<std::size_t>(best)];
  return b.labelled || b.bright == a.bright ? -1 : best;
}

}  // namespace srd::dsp
