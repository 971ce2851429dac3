// SPDX-License-Identifier: Apache-2.0
#include "host/fusion/board_watch.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace srd::host {
namespace {

// Sets of boards that one board has been seen in. More come only where boards come and go all the time.
constexpr std::size_t kMostSets = 64;

}  // namespace

void BoardWatch::forget(const std::string& name) { boards_.erase(name); }

bool BoardWatch::has_moved(const std::string& name) const {
  const auto found = boards_.find(name);
  return found != boards_.end() && found->second.moved;
}

std::vector<BoardWatch::Event> BoardWatch::take_events() { return std::exchange(events_, {}); }

bool BoardWatch::look(std::int64_t time_ns, std::span<const Part> parts, Eigen::Index modes) {
  std::uint32_t trusted = 0;
  int trusted_count = 0;
  for (const Part& part : parts) {
    if (has_moved(part.name)) continue;
    trusted |= part.bit;
    ++trusted_count;
  }
  bool consistent = true;
  const Part* worst = nullptr;
  Disagreement::Shift worst_shift;
  for (const Part& part : parts) {
    State& state = boards_[part.name];
    std::vector<const Contribution*> rest;
    for (const Part& other : parts)
      if (&other != &part && (trusted & other.bit) != 0) rest.push_back(&other.contribution);
    const auto others = add_information(rest, modes);
    if (!others) continue;
    const BoardMap& map = *part.map;
    const std::uint32_t set = trusted | part.bit;
    if (state.by_set.size() >= kMostSets && !state.by_set.contains(set)) state.by_set.clear();
    Disagreement& disagreement = state.by_set[set];
    const bool fits = disagreement.add(time_ns, part.surface.coefficients - map.constant - map.map * others->coefficients,
                                       part.surface.covariance + map.map * others->covariance * map.map.transpose());
    const auto shift = disagreement.shift();
    if (state.moved) {
      if (!shift || shift->significance > kTold / 2) continue;
      state.moved = state.told = false;
      events_.push_back({part.name, false, false, shift->significance, shift->mm});
      continue;
    }
    consistent = consistent && fits;
    if (shift && shift->significance > std::max(kTold, worst_shift.significance)) {
      worst_shift = *shift;
      worst = &part;
    }
  }
  if (worst == nullptr) return consistent;
  const bool known = trusted_count > 2;
  State& state = boards_[worst->name];
  if (!state.told) events_.push_back({worst->name, true, !known, worst_shift.significance, worst_shift.mm});
  state.told = true;
  state.moved = known;
  // The others only seemed to move, against it.
  if (known)
    for (const Part& part : parts)
      if (&part != worst)
        for (auto& [set, disagreement] : boards_[part.name].by_set) disagreement.forget_recent();
  return known && consistent;
}

}  // namespace srd::host
