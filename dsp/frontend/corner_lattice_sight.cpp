// SPDX-License-Identifier: Apache-2.0
// Corners that a lattice expects, that were not detected, and that the image shows all the same: members of CornerLattice.
#include <algorithm>
#include <cmath>

#include "dsp/frontend/corner_lattice.hpp"
#include "dsp/frontend/faint_corner.hpp"

namespace srd::dsp {

namespace {

constexpr int kDeepest = 6;  // sighted corners in a row: then the map is guessed rather than known
constexpr int kMembers = 5;  // that a map into the unknown comes from
constexpr std::array kSqueezes{1.0f, 0.8f, 0.64f, 0.5f, 1.25f};
constexpr float kTaken = 0.35f;  // of a step: another corner so near is the same crossing, and it does not fit there

// With the step in this direction so much shorter, and the place as much nearer to where the step comes from.
CornerLattice::LocalMap squeezed_map(CornerLattice::LocalMap map, int direction, float squeeze) {
  const bool along_columns = direction % 2 == 0;
  float &step_u = along_columns ? map.column_u : map.row_u, &step_v = along_columns ? map.column_v : map.row_v;
  const float back = (direction < 2 ? 1.0f : -1.0f) * (1 - squeeze);
  map.u -= back * step_u;
  map.v -= back * step_v;
  step_u *= squeeze;
  step_v *= squeeze;
  return map;
}

}  // namespace

// One ring round all pieces. True: some were sighted, or another piece was met.
bool CornerLattice::sight(CornerLinks& links) {
  if (!links.sees_edges()) return false;
  bool any = false;
  meetings_.clear();
  const std::size_t before = nodes_.size();
  for (std::size_t i = 0; i < before; ++i)
    for (int direction = 0; direction < 4; ++direction)
      if (places_[i].piece >= 0) any = sight_at(links, i, direction) || any;
  return any || !meetings_.empty();
}

bool CornerLattice::sight_at(CornerLinks& links, std::size_t from, int direction) {
  const std::size_t d = static_cast<std::size_t>(direction);
  const Place& at = places_[from];
  const Place place{at.piece, at.row + kRowSteps[d], at.column + kColumnSteps[d], 0};
  if (nodes_[from].depth >= kDeepest || find(place.piece, place.row, place.column) >= 0) return false;
  LocalMap map;
  if (!local_map(place.piece, place.row, place.column, -1, map) || map.members < kMembers) return false;
  CornerNode node;
  FaintCorner corner;
  node.bright = bright_at(place.piece, place.row, place.column);
  // The step that leads there may be another than the one before it: waves squeeze and stretch squares within two of them.
  for (const float squeeze : kSqueezes) {
    const LocalMap squeezed = squeezed_map(map, direction, squeeze);
    FaintCorner other;
    if (!find_faint_corner(links.image(), squeezed, node.bright, nodes_[from].contrast, other)) continue;
    if (other.likeness > corner.likeness) corner = other;
  }
  if (corner.likeness == 0) return false;
  node.u = corner.u;
  node.v = corner.v;
  node.contrast = corner.contrast;
  const float column = std::hypot(map.column_u, map.column_v), row = std::hypot(map.row_u, map.row_v);
  node.along = {{{map.column_u / column, map.column_v / column},
                 {map.row_u / row, map.row_v / row},
                 {-map.column_u / column, -map.column_v / column},
                 {-map.row_u / row, -map.row_v / row}}};
  const float taken = kTaken * std::min(row, column);
  int there = -1;
  float nearest = taken;
  links.near(node.u, node.v, taken, [&](std::size_t i) {
    if (!nodes_[i].usable || (i >= corners_ && places_[i].piece < 0)) return;
    const float distance = std::hypot(nodes_[i].u - node.u, nodes_[i].v - node.v);
    if (distance >= nearest) return;
    nearest = distance;
    there = static_cast<int>(i);
  });
  int seen = 0, beside = 0, depth = kDeepest;
  for (int side = 0; side < 4; ++side) {
    const std::size_t s = static_cast<std::size_t>(side);
    const int next = find(place.piece, place.row + kRowSteps[s], place.column + kColumnSteps[s]);
    if (next < 0) continue;
    ++beside;
    const CornerNode& other = nodes_[static_cast<std::size_t>(next)];
    depth = std::min<int>(depth, other.depth);
    if (links.edge_seen(node, side, other)) ++seen;
  }
  if (2 * seen <= beside) return false;
  if (there >= 0) {
    const CornerNode& other = nodes_[static_cast<std::size_t>(there)];
    const Place& its = places_[static_cast<std::size_t>(there)];
    int turn;
    if (its.piece == place.piece || !turn_towards(other, map, turn)) return false;
    if ((other.bright != ((turn & 1) != 0)) != node.bright) return false;
    if (its.piece < 0) {
      // Contradicted when it stood alone, it may come back beside two.
      const int refused = refused_[static_cast<std::size_t>(there)];
      if (refused > kReturns || (refused > 0 && beside < 2)) return false;
      settle(static_cast<std::size_t>(there), {place.piece, place.row, place.column, turn});
      return true;
    }
    const int turned = modulo4(turn - its.turn);
    int its_row = its.row, its_column = its.column;
    turn_cell(-turned, its_row, its_column);
    meet(place.piece, its.piece, {turned, place.row - its_row, place.column - its_column, 1, 1});
    return false;
  }
  node.depth = static_cast<std::uint8_t>(depth + 1);
  if (!links.add(node)) return false;
  nodes_ = links.nodes();
  places_.push_back({});
  misfit_.push_back(0);
  distance_.push_back(0);
  refused_.push_back(0);
  if (2 * nodes_.size() > table_.size()) rebuild_table();
  settle(nodes_.size() - 1, place);
  return true;
}

int CornerLattice::beside(std::size_t node, float& step, float& contrast) const {
  const Place& at = places_[node];
  int count = 0;
  for (std::size_t d = 0; d < 4 && at.piece >= 0; ++d) {
    const int next = find(at.piece, at.row + kRowSteps[d], at.column + kColumnSteps[d]);
    if (next < 0 || static_cast<std::size_t>(next) >= corners_) continue;
    const CornerNode& other = nodes_[static_cast<std::size_t>(next)];
    const float length = std::hypot(other.u - nodes_[node].u, other.v - nodes_[node].v);
    step = count > 0 ? std::min(step, length) : length;
    contrast = count > 0 ? std::min(contrast, other.contrast) : other.contrast;
    ++count;
  }
  return count;
}

}  // namespace srd::dsp
