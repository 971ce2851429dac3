// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/corner_lattice.hpp"

#include <algorithm>
#include <cmath>

namespace srd::dsp {

namespace {

constexpr int kReach = 2;            // cells: how far round a cell its map is taken from
constexpr float kContinues = 0.60f;  // of a step: a linked neighbour against the steps before and beside it
constexpr float kLinked = 0.45f;     // of a step: a corner that a link leads to against the map
constexpr float kDue = 0.30f;        // of a step: a corner without a link
constexpr float kAligned = 0.80f;    // cosine between an edge and the map's step
constexpr float kAlone = 0.12f;      // of a step: a corner with a single neighbour
constexpr int kSmallest = 4;         // corners
constexpr float kNoSupport = 1e9f;   // a misfit: no map without the corner itself
// At the border the map is carried on, not laid between: linear, it misses 3/2 of the bend of a step there, 1/2 inside. What is
// usual nearby comes from inside.
constexpr float kBorder = 3.0f, kBorderMost = 0.30f;
constexpr int kPasses = 64;
constexpr int kRings = 12;

std::uint64_t key_of(int piece, int row, int column) {
  const auto bits = [](int x) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x) & 0xfffffu); };
  return (static_cast<std::uint64_t>(piece + 1) << 40) | (bits(row) << 20) | bits(column);
}

std::size_t hash_of(std::uint64_t key) { return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ull) >> 32); }

}  // namespace

CornerLattice::CornerLattice(std::size_t max_corners) {
  std::size_t size = 16;
  const std::size_t max_nodes = 2 * max_corners;  // as many are sighted at the most
  while (size < 4 * max_nodes) size *= 2;
  table_.reserve(size);
  places_.reserve(max_nodes);
  queue_.reserve(max_nodes);
  misfit_.reserve(max_nodes);
  distance_.reserve(max_nodes);
  refused_.reserve(max_nodes);
  meetings_.reserve(kMaxMeetings);
}

void CornerLattice::build(CornerLinks& links) {
  nodes_ = links.nodes();
  corners_ = nodes_.size();
  places_.assign(nodes_.size(), {});
  misfit_.assign(nodes_.size(), 0);
  distance_.assign(nodes_.size(), 0);
  refused_.assign(nodes_.size(), 0);
  pieces_ = 0;
  rebuild_table();
  // The best supported cells first: a corner amid four of them is hardly a false one.
  for (const int support : {4, 2, 1})
    for (std::size_t i = 0; i < nodes_.size() && pieces_ < kMaxPieces; ++i) {
      int cells = 0;
      for (int bit = 0; bit < 4; ++bit) cells += (nodes_[i].cells >> bit) & 1;
      if (places_[i].piece < 0 && cells >= support) flood(i);
    }
  for (int pass = 0; pass < 4; ++pass) {
    while (attach(links)) {}
    const bool pruned = prune();
    drop_small();
    const bool joined = join(links);
    if (!pruned && !joined) break;
  }
  // A ring of sighted corners at a time, each no further than kDeepest from a detected one.
  for (int ring = 0; ring < kRings && sight(links); ++ring) {
    while (attach(links)) {}
    (void)prune();
    drop_small();
    // What contradicted a small piece's map may agree with that of the larger.
    if (const bool met = join_where_they_meet(); join(links) || met) refused_.assign(refused_.size(), 0);
  }
  while (attach(links)) {}
  (void)prune();
  drop_loose();
  drop_small();
  measure_misfits();
}

// Detected corners that hang on sighted ones alone: of a board that ends there, they are as likely as not something else.
void CornerLattice::drop_loose() {
  for (std::size_t i = 0; i < corners_; ++i) {
    const Place at = places_[i];
    if (at.piece < 0) continue;
    int detected = 0, beside = 0;
    for (std::size_t d = 0; d < 4; ++d) {
      const int next = find(at.piece, at.row + kRowSteps[d], at.column + kColumnSteps[d]);
      if (next < 0 || places_[static_cast<std::size_t>(next)].piece < 0) continue;
      ++beside;
      if (static_cast<std::size_t>(next) < corners_) ++detected;
    }
    if (detected == 0 && beside < 3) release(i);
  }
  rebuild_table();
}

// Breadth first over the links that are sides of cells.
void CornerLattice::flood(std::size_t from) {
  const int piece = pieces_++;
  bright_[static_cast<std::size_t>(piece)] = nodes_[from].bright;
  size_[static_cast<std::size_t>(piece)] = 0;
  queue_.clear();
  settle(from, {piece, 0, 0, 0});
  queue_.push_back(static_cast<int>(from));
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const std::size_t a = static_cast<std::size_t>(queue_[head]);
    const Place at = places_[a];
    for (int direction = 0; direction < 4; ++direction) {
      const int half = modulo4(direction + at.turn);
      const CornerNode& node = nodes_[a];
      // A side of a cell: the cell before or the one after the half edge.
      if (((node.cells >> half) & 1) == 0 && ((node.cells >> modulo4(half + 3)) & 1) == 0) continue;
      const int next = node.link[static_cast<std::size_t>(half)];
      if (next < 0 || places_[static_cast<std::size_t>(next)].piece >= 0) continue;
      const std::size_t b = static_cast<std::size_t>(next);
      const Place place{piece, at.row + kRowSteps[static_cast<std::size_t>(direction)],
                        at.column + kColumnSteps[static_cast<std::size_t>(direction)],
                        modulo4(node.back[static_cast<std::size_t>(half)] - direction - 2)};
      if (find(piece, place.row, place.column) >= 0 || !continues(a, direction, b)) continue;
      settle(b, place);
      queue_.push_back(next);
    }
  }
}

// The step from a member to b against the step that led to it, or against the same step a row or column beside.
bool CornerLattice::continues(std::size_t from, int direction, std::size_t to) const {
  const Place& at = places_[from];
  const auto member = [&](int steps, int sideways) {
    const std::size_t d = static_cast<std::size_t>(direction), s = static_cast<std::size_t>(modulo4(direction + 1));
    return find(at.piece, at.row + steps * kRowSteps[d] + sideways * kRowSteps[s],
                at.column + steps * kColumnSteps[d] + sideways * kColumnSteps[s]);
  };
  const CornerNode &a = nodes_[from], &b = nodes_[to];
  const auto near = [&](const CornerNode& start, const CornerNode& end) {
    const float du = end.u - start.u, dv = end.v - start.v;
    return std::hypot(b.u - a.u - du, b.v - a.v - dv) <= kContinues * std::hypot(du, dv);
  };
  const auto node = [&](int i) -> const CornerNode& { return nodes_[static_cast<std::size_t>(i)]; };
  bool known = false;
  if (const int behind = member(-1, 0); behind >= 0) {
    if (near(node(behind), a)) return true;
    known = true;
  }
  for (const int side : {-1, 1}) {
    const int here = member(0, side), there = member(1, side);
    if (here < 0 || there < 0) continue;
    if (near(node(here), node(there))) return true;
    known = true;
  }
  return !known;
}

bool CornerLattice::bright_at(int piece, int row, int column) const {
  return bright_[static_cast<std::size_t>(piece)] != (((row + column) & 1) != 0);
}

// Weighted least squares of a plane through the members round the cell. The nearest count most: water bends the map
// within a few squares.
bool CornerLattice::local_map(int piece, int row, int column, int without, LocalMap& map, bool detected_only) const {
  float w = 0, wr = 0, wc = 0, wrr = 0, wrc = 0, wcc = 0, u = 0, ur = 0, uc = 0, v = 0, vr = 0, vc = 0;
  float base_u = 0, base_v = 0;
  map.members = 0;
  for (int dr = -kReach; dr <= kReach; ++dr)
    for (int dc = -kReach; dc <= kReach; ++dc) {
      const int i = find(piece, row + dr, column + dc);
      if (i < 0 || i == without) continue;
      if (detected_only && static_cast<std::size_t>(i) >= corners_) continue;
      const CornerNode& node = nodes_[static_cast<std::size_t>(i)];
      if (map.members++ == 0) {
        base_u = node.u;
        base_v = node.v;
      }
      const float r = static_cast<float>(dr), c = static_cast<float>(dc), d2 = std::max(r * r + c * c, 0.5f);
      const float weight = 1 / (d2 * d2), du = weight * (node.u - base_u), dv = weight * (node.v - base_v);
      w += weight;
      wr += weight * r;
      wc += weight * c;
      wrr += weight * r * r;
      wrc += weight * r * c;
      wcc += weight * c * c;
      u += du;
      ur += du * r;
      uc += du * c;
      v += dv;
      vr += dv * r;
      vc += dv * c;
    }
  if (map.members < 3) return false;
  // Centred: two by two.
  const float mr = wr / w, mc = wc / w;
  const float srr = wrr - mr * wr, src = wrc - mr * wc, scc = wcc - mc * wc, det = srr * scc - src * src;
  if (!(det > 1e-3f * w * w)) return false;
  const auto solve = [&](float s, float sr, float sc, float& at, float& by_row, float& by_column) {
    const float tr = sr - mr * s, tc = sc - mc * s;
    by_row = (tr * scc - tc * src) / det;
    by_column = (tc * srr - tr * src) / det;
    at = s / w - by_row * mr - by_column * mc;
  };
  solve(u, ur, uc, map.u, map.row_u, map.column_u);
  solve(v, vr, vc, map.v, map.row_v, map.column_v);
  map.u += base_u;
  map.v += base_v;
  map.step = 0.5f * (std::hypot(map.row_u, map.row_v) + std::hypot(map.column_u, map.column_v));
  return map.step > 0;
}

// The turn that lays the corner's edges along the map's steps; false: neither does.
bool CornerLattice::turn_towards(const CornerNode& node, const LocalMap& map, int& turn) {
  const float row_length = std::hypot(map.row_u, map.row_v), column_length = std::hypot(map.column_u, map.column_v);
  if (!(row_length > 0 && column_length > 0)) return false;
  float best = -1;
  for (int k = 0; k < 4; ++k) {
    const auto &column = node.along[static_cast<std::size_t>(k)], &row = node.along[static_cast<std::size_t>(modulo4(k + 1))];
    const float c = (column[0] * map.column_u + column[1] * map.column_v) / column_length;
    const float r = (row[0] * map.row_u + row[1] * map.row_v) / row_length;
    if (std::min(c, r) <= best) continue;
    best = std::min(c, r);
    turn = k;
  }
  return best >= kAligned;
}

// The free corner that the map of a piece expects at an empty cell; -1: none, or more than one.
int CornerLattice::due(const CornerLinks& links, int piece, int row, int column, Place& place) const {
  LocalMap map;
  if (!local_map(piece, row, column, -1, map)) return -1;
  int best = -1;
  float nearest = 0, second = 0;
  // The shorter step: what the next cell's corner is away.
  const float step = std::min(std::hypot(map.row_u, map.row_v), std::hypot(map.column_u, map.column_v));
  links.near(map.u, map.v, kLinked * map.step, [&](std::size_t i) {
    const CornerNode& node = nodes_[i];
    if (i >= corners_ || !node.usable || places_[i].piece >= 0) return;
    int turn;
    if (!turn_towards(node, map, turn)) return;
    if ((node.bright != ((turn & 1) != 0)) != bright_at(piece, row, column)) return;
    bool linked = false;
    int seen = 0, beside = 0;
    for (int direction = 0; direction < 4; ++direction) {
      const std::size_t d = static_cast<std::size_t>(direction);
      const int next = find(piece, row + kRowSteps[d], column + kColumnSteps[d]);
      if (next < 0) continue;
      const int half = modulo4(direction + turn);
      ++beside;
      if (links.edge_seen(node, half, nodes_[static_cast<std::size_t>(next)])) ++seen;
      linked = linked || node.link[static_cast<std::size_t>(half)] == next;
    }
    if (2 * seen <= beside) return;
    // Contradicted when it stood alone, it may come back beside two.
    if (refused_[i] != 0 && (refused_[i] > kReturns || beside < 2 || seen < beside)) return;
    const float distance = std::hypot(node.u - map.u, node.v - map.v) / step;
    if (distance > (linked ? kLinked : kDue)) return;
    if (best < 0 || distance < nearest) {
      second = best < 0 ? second : nearest;
      if (best < 0) second = 1e9f;
      best = static_cast<int>(i);
      nearest = distance;
      place = {piece, row, column, turn};
    } else {
      second = std::min(second, distance);
    }
  });
  return best >= 0 && second > 2 * nearest ? best : -1;
}

// Empty cells next to members. True: some were filled.
bool CornerLattice::attach(const CornerLinks& links) {
  bool any = false;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Place at = places_[i];
    if (at.piece < 0) continue;
    for (std::size_t d = 0; d < 4; ++d) {
      const int row = at.row + kRowSteps[d], column = at.column + kColumnSteps[d];
      if (find(at.piece, row, column) >= 0) continue;
      Place place;
      const int node = due(links, at.piece, row, column, place);
      if (node < 0) continue;
      settle(static_cast<std::size_t>(node), place);
      any = true;
    }
  }
  return any;
}

void CornerLattice::measure_misfits() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Place& at = places_[i];
    distance_[i] = misfit_[i] = 0;
    if (at.piece < 0) continue;
    LocalMap map;
    // What was only sighted speaks against a detected corner where nothing else does.
    const bool detected = i < corners_ && local_map(at.piece, at.row, at.column, static_cast<int>(i), map, true);
    if (!detected && !local_map(at.piece, at.row, at.column, static_cast<int>(i), map)) {
      distance_[i] = -1;  // hangs on by a thread
      continue;
    }
    distance_[i] = std::hypot(nodes_[i].u - map.u, nodes_[i].v - map.v) / map.step;
    misfit_[i] = map.step;
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Place& at = places_[i];
    if (at.piece < 0) continue;
    if (distance_[i] < 0) {
      misfit_[i] = kNoSupport;
      continue;
    }
    misfit_[i] = misfit_of(i, misfit_[i]);
  }
}

float CornerLattice::misfit_of(std::size_t node, float step) {
  const Place& at = places_[node];
  constexpr std::size_t kAround = (2 * kReach + 1) * (2 * kReach + 1);
  std::array<float, kAround> distances{}, contrasts{};
  std::ptrdiff_t n = 0, beside = 0;
  for (int dr = -kReach; dr <= kReach; ++dr)
    for (int dc = -kReach; dc <= kReach; ++dc) {
      const int k = dr == 0 && dc == 0 ? -1 : find(at.piece, at.row + dr, at.column + dc);
      if (k < 0 || distance_[static_cast<std::size_t>(k)] < 0) continue;
      if (std::abs(dr) + std::abs(dc) == 1) ++beside;
      distances[static_cast<std::size_t>(n)] = distance_[static_cast<std::size_t>(k)];
      contrasts[static_cast<std::size_t>(n++)] = nodes_[static_cast<std::size_t>(k)].contrast;
    }
  if (n == 0) return kNoSupport;
  const auto middle = [n](std::array<float, kAround>& values) {
    std::nth_element(values.begin(), values.begin() + n / 2, values.begin() + n);
    return values[static_cast<std::size_t>(n / 2)];
  };
  const float bend = kUsual * middle(distances), own = kOfStep + kOfPixel / step;
  float limit = beside == 4 ? bend + own : std::max(bend, std::min(kBorder * bend, kBorderMost)) + own;
  if (beside < 2) limit = std::min(limit, kAlone);
  if (node >= corners_) return distance_[node] / limit;
  // A corner in a shadow is as faint as one of something else, but it lies where it should.
  const float faint = std::max(1.0f, middle(contrasts) / std::max(nodes_[node].contrast, 1.0f));
  return distance_[node] / limit * faint * faint;
}

// The worst of each neighbourhood goes first: it spoils the map of those beside it. True: some went.
bool CornerLattice::prune() {
  bool any = false;
  for (int pass = 0; pass < kPasses; ++pass) {
    measure_misfits();
    queue_.clear();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Place& at = places_[i];
      if (at.piece < 0 || misfit_[i] <= 1) continue;
      bool worst = true;
      for (int dr = -kReach; worst && dr <= kReach; ++dr)
        for (int dc = -kReach; worst && dc <= kReach; ++dc) {
          const int k = find(at.piece, at.row + dr, at.column + dc);
          worst = k < 0 || misfit_[static_cast<std::size_t>(k)] <= misfit_[i];
        }
      if (worst) queue_.push_back(static_cast<int>(i));
    }
    if (queue_.empty()) break;
    for (const int i : queue_) {
      release(static_cast<std::size_t>(i));
      if (misfit_[static_cast<std::size_t>(i)] < kNoSupport) ++refused_[static_cast<std::size_t>(i)];
    }
    rebuild_table();
    any = true;
  }
  return any;
}

void CornerLattice::drop_small() {
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (places_[i].piece >= 0 && size_[static_cast<std::size_t>(places_[i].piece)] < kSmallest) release(i);
  rebuild_table();
}

// How far from its neighbours' map a corner is nearby, the median, in steps.
float CornerLattice::usual_at(int piece, int row, int column) const {
  std::array<float, (2 * kReach + 1) * (2 * kReach + 1)> around{};
  std::ptrdiff_t n = 0;
  for (int dr = -kReach; dr <= kReach; ++dr)
    for (int dc = -kReach; dc <= kReach; ++dc) {
      const int k = find(piece, row + dr, column + dc);
      if (k >= 0 && distance_[static_cast<std::size_t>(k)] >= 0)
        around[static_cast<std::size_t>(n++)] = distance_[static_cast<std::size_t>(k)];
    }
  if (n == 0) return 0;
  std::nth_element(around.begin(), around.begin() + n / 2, around.begin() + n);
  return around[static_cast<std::size_t>(n / 2)];
}

void CornerLattice::settle(std::size_t node, const Place& place) {
  places_[node] = place;
  if (node < corners_) ++size_[static_cast<std::size_t>(place.piece)];
  insert(place, static_cast<int>(node));
}

// The table is rebuilt by the caller.
void CornerLattice::release(std::size_t node) {
  if (node < corners_) --size_[static_cast<std::size_t>(places_[node].piece)];
  places_[node] = {};
}

void CornerLattice::rebuild_table() {
  std::size_t size = 16;
  while (size < 4 * nodes_.size()) size *= 2;
  mask_ = size - 1;
  table_.assign(size, {0, -1});
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (places_[i].piece >= 0) insert(places_[i], static_cast<int>(i));
}

void CornerLattice::insert(const Place& place, int node) {
  const std::uint64_t key = key_of(place.piece, place.row, place.column);
  std::size_t at = hash_of(key) & mask_;
  while (table_[at].node >= 0) at = (at + 1) & mask_;
  table_[at] = {key, node};
}

int CornerLattice::find(int piece, int row, int column) const {
  const std::uint64_t key = key_of(piece, row, column);
  for (std::size_t at = hash_of(key) & mask_; table_[at].node >= 0; at = (at + 1) & mask_)
    if (table_[at].key == key) return table_[at].node;
  return -1;
}

}  // namespace srd::dsp
