// SPDX-License-Identifier: Apache-2.0
// Pieces of a lattice that agree across a gap become one: members of CornerLattice.
#include <algorithm>
#include <cmath>

#include "dsp/frontend/corner_lattice.hpp"

namespace srd::dsp {

namespace {

constexpr float kGap = 3.4f;  // steps between the corners of two pieces that may be joined
constexpr float kTouching = 1.5f;
constexpr float kMapsDiffer = 0.5f;  // of a step, between the steps of two pieces
constexpr float kOneThing = 0.35f;   // of a step, between two sightings of one corner
constexpr int kVotes = 3;
constexpr float kMeetingsAgree = 0.9f;
constexpr float kAgree = 0.75f;  // of all votes, by weight

}  // namespace

bool CornerLattice::join(const CornerLinks& links) {
  bool any = false;
  for (bool again = true; again;) {
    again = false;
    for (int host = 0; host < pieces_; ++host)
      for (int guest = 0; guest < pieces_; ++guest) {
        const int host_size = size_[static_cast<std::size_t>(host)], guest_size = size_[static_cast<std::size_t>(guest)];
        if (host == guest || guest_size == 0 || host_size < guest_size || (host_size == guest_size && host > guest)) continue;
        Shift shift;
        if (!agree(links, host, guest, shift)) continue;
        move(host, guest, shift);
        again = any = true;
      }
  }
  return any;
}

// Each corner of the guest near the host votes for where the host's map puts it.
bool CornerLattice::agree(const CornerLinks& links, int host, int guest, Shift& shift) const {
  std::array<Shift, 32> shifts{};
  std::size_t count = 0;
  float total = 0;
  for (std::size_t q = 0; q < corners_; ++q) {
    const Place& at = places_[q];
    if (at.piece != guest) continue;
    LocalMap own;
    if (!local_map(guest, at.row, at.column, -1, own)) continue;
    int from = -1;
    float nearest = (links.sees_edges() ? kTouching : kGap) * own.step;
    links.near(nodes_[q].u, nodes_[q].v, nearest, [&](std::size_t i) {
      if (places_[i].piece != host) return;
      const float d = std::hypot(nodes_[i].u - nodes_[q].u, nodes_[i].v - nodes_[q].v);
      if (d >= nearest) return;
      nearest = d;
      from = static_cast<int>(i);
    });
    if (from < 0) continue;
    const Place& near = places_[static_cast<std::size_t>(from)];
    LocalMap map;
    int turn;
    // Across a wide gap the maps say little.
    const float gap = std::max(nearest / own.step, 1.0f), weight = 1 / (gap * gap * gap * gap);
    total += weight;
    if (!local_map(host, near.row, near.column, -1, map) || !turn_towards(nodes_[q], map, turn)) continue;
    const int rho = modulo4(turn - at.turn);
    // The guest's steps along the host's directions: rho quarter turns on.
    const auto along = [&](int direction) {
      const int d = modulo4(direction);
      const float sign = d >= 2 ? -1.0f : 1.0f;
      return d % 2 == 0 ? std::array{sign * own.column_u, sign * own.column_v} : std::array{sign * own.row_u, sign * own.row_v};
    };
    const auto column = along(rho), row = along(rho + 1);
    // Boards that do not bend must agree well.
    const float usual = std::max(usual_at(guest, at.row, at.column), usual_at(host, near.row, near.column));
    const float limit = 1.5f * gap * (kUsual * usual + kOfStep + kOfPixel / map.step);
    const float differ = std::min(kMapsDiffer, 2 * limit);
    if (std::hypot(column[0] - map.column_u, column[1] - map.column_v) > differ * map.step ||
        std::hypot(row[0] - map.row_u, row[1] - map.row_v) > differ * map.step)
      continue;
    // Half-way between the two maps: the bend of the gap counts to first order.
    const float ru = 0.5f * (row[0] + map.row_u), rv = 0.5f * (row[1] + map.row_v);
    const float cu = 0.5f * (column[0] + map.column_u), cv = 0.5f * (column[1] + map.column_v);
    const float det = ru * cv - rv * cu, du = nodes_[q].u - map.u, dv = nodes_[q].v - map.v;
    if (std::abs(det) < 0.1f * map.step * map.step) continue;
    const float r = (du * cv - dv * cu) / det, c = (dv * ru - du * rv) / det;
    const int dr = static_cast<int>(std::lround(r)), dc = static_cast<int>(std::lround(c));
    if (std::hypot(r - static_cast<float>(dr), c - static_cast<float>(dc)) > limit) continue;
    if (bright_at(host, near.row + dr, near.column + dc) != (nodes_[q].bright != ((turn & 1) != 0))) continue;
    int turned_row = at.row, turned_column = at.column;
    turn_cell(-rho, turned_row, turned_column);
    const Shift vote{rho, near.row + dr - turned_row, near.column + dc - turned_column, 1, weight};
    std::size_t k = 0;
    while (k < count && (shifts[k].turn != vote.turn || shifts[k].row != vote.row || shifts[k].column != vote.column)) ++k;
    if (k == shifts.size()) continue;
    if (k == count)
      shifts[count++] = vote;
    else {
      ++shifts[k].votes;
      shifts[k].weight += weight;
    }
  }
  if (count == 0) return false;
  shift = *std::max_element(shifts.begin(), shifts.begin() + static_cast<std::ptrdiff_t>(count),
                            [](const Shift& a, const Shift& b) { return a.weight < b.weight; });
  if (shift.votes < kVotes || shift.weight < kAgree * total) return false;
  return overlap_fits(host, guest, shift);
}

bool CornerLattice::overlap_fits(int host, int guest, const Shift& shift) const {
  for (std::size_t q = 0; q < nodes_.size(); ++q) {
    if (places_[q].piece != guest) continue;
    int row = places_[q].row, column = places_[q].column;
    turn_cell(-shift.turn, row, column);
    const int taken = find(host, row + shift.row, column + shift.column);
    if (taken < 0) continue;
    // Where both see something in one cell, it must be one thing, and no more than one of them may have measured it.
    const CornerNode &ours = nodes_[q], &theirs = nodes_[static_cast<std::size_t>(taken)];
    if (ours.depth == 0 && theirs.depth == 0) return false;
    LocalMap map;
    if (!local_map(guest, places_[q].row, places_[q].column, -1, map)) return false;
    if (std::hypot(ours.u - theirs.u, ours.v - theirs.v) > kOneThing * map.step) return false;
  }
  return true;
}

void CornerLattice::meet(int host, int guest, const Shift& shift) {
  for (Meeting& known : meetings_) {
    if (known.host != host || known.guest != guest || known.shift.turn != shift.turn || known.shift.row != shift.row ||
        known.shift.column != shift.column)
      continue;
    ++known.shift.votes;
    return;
  }
  if (meetings_.size() < kMaxMeetings) meetings_.push_back({host, guest, shift});
}

// Pieces that have come to each other's corners. What a piece sights differently in two places joins it to nothing.
bool CornerLattice::join_where_they_meet() {
  bool any = false;
  while (!meetings_.empty()) {
    const Meeting best = *std::max_element(meetings_.begin(), meetings_.end(),
                                           [](const Meeting& a, const Meeting& b) { return a.shift.votes < b.shift.votes; });
    if (best.shift.votes < kVotes) break;
    int all = 0;
    for (const Meeting& each : meetings_)
      if (each.host == best.host && each.guest == best.guest) all += each.shift.votes;
    const bool agreed = static_cast<float>(best.shift.votes) >= kMeetingsAgree * static_cast<float>(all);
    if (agreed && overlap_fits(best.host, best.guest, best.shift)) {
      move(best.host, best.guest, best.shift);
      any = true;
      // Of the pieces as they were.
      std::erase_if(meetings_, [&](const Meeting& each) {
        return each.host == best.guest || each.guest == best.guest || each.host == best.host || each.guest == best.host;
      });
    } else {
      std::erase_if(meetings_, [&](const Meeting& each) { return each.host == best.host && each.guest == best.guest; });
    }
  }
  meetings_.clear();
  return any;
}

void CornerLattice::move(int host, int guest, const Shift& shift) {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Place& place = places_[i];
    if (place.piece != guest) continue;
    turn_cell(-shift.turn, place.row, place.column);
    place.row += shift.row;
    place.column += shift.column;
    place.turn = modulo4(place.turn + shift.turn);
    place.piece = host;
    const int taken = find(host, place.row, place.column);
    if (taken < 0) continue;
    // What is detected stays rather than what was sighted.
    if (nodes_[i].depth == 0)
      places_[static_cast<std::size_t>(taken)] = {};
    else
      place = {};
  }
  size_[static_cast<std::size_t>(host)] += size_[static_cast<std::size_t>(guest)];
  size_[static_cast<std::size_t>(guest)] = 0;
  rebuild_table();
}

}  // namespace srd::dsp
