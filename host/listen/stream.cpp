// SPDX-License-Identifier: Apache-2.0
#include "host/listen/stream.hpp"

#include <algorithm>

namespace srd::host {

using proto::SequenceRange;

Stream::Stream(SequenceSet in_file, std::uint64_t oldest_held)
    : start_(in_file.empty() ? oldest_held : in_file.ranges().front().begin), known_(std::move(in_file)) {}

void Stream::take(std::uint64_t sequence, proto::CoefficientFrame frame, bool room) {
  if (knows(sequence)) {
    ++counts_.duplicates;
    return;
  }
  const bool waits = sequence != known_.first_missing(start_);
  if (waits && (!room || waiting_.size() >= kMaxWaiting || known_.ranges().size() >= kMaxRanges)) {
    // The earlier a frame, the sooner it can be written: the latest one that waits has to come again.
    ++counts_.refused;
    if (waiting_.empty() || sequence > waiting_.rbegin()->first) return;
    known_.remove(waiting_.rbegin()->first);
    waiting_.erase(std::prev(waiting_.end()));
  }
  if (sequence < known_.end()) ++counts_.late;
  known_.add(sequence);
  waiting_.emplace(sequence, std::move(frame));
}

void Stream::lose(SequenceRange range) {
  counts_.lost += range.size();
  known_.add(range);
  // Kept in order; neighbours are one range.
  const auto after = std::lower_bound(lost_.begin(), lost_.end(), range.begin,
                                      [](const SequenceRange& r, std::uint64_t begin) { return r.end < begin; });
  if (after != lost_.end() && after->end == range.begin)
    after->end = range.end;
  else if (lost_.size() < kMaxLostRanges)
    lost_.insert(after, range);
}

void Stream::give_up_below(std::uint64_t oldest_held) {
  std::vector<SequenceRange> gaps;
  known_.for_missing(known_.first_missing(start_), oldest_held, [&](const SequenceRange& gap) {
    gaps.push_back(gap);
    return true;
  });
  for (const SequenceRange& gap : gaps) lose(gap);
}

void Stream::take_lost_ranges(std::span<const SequenceRange> ranges) {
  for (const SequenceRange& range : ranges) {
    std::vector<SequenceRange> gaps;
    known_.for_missing(range.begin, range.end, [&](const SequenceRange& gap) {
      gaps.push_back(gap);
      return true;
    });
    for (const SequenceRange& gap : gaps) lose(gap);
  }
}

void Stream::give_up() { give_up_below(known_.end()); }

std::uint64_t Stream::delivered_below() const {
  const std::uint64_t gap = known_.first_missing(start_);
  return waiting_.empty() ? gap : std::min(gap, waiting_.begin()->first);
}

std::optional<Stream::Ready> Stream::ready() const {
  if (waiting_.empty() || waiting_.begin()->first >= known_.first_missing(start_)) return std::nullopt;
  return Ready{waiting_.begin()->first, &waiting_.begin()->second};
}

void Stream::pop_ready() {
  waiting_.erase(waiting_.begin());
  ++counts_.delivered;
}

void Stream::describe(proto::Acknowledgement& out) const {
  out.first_missing = delivered_below();
  out.known_end = std::max(out.first_missing, known_.end());
  out.missing.clear();
  known_.for_missing(out.first_missing, known_.end(), [&](const SequenceRange& gap) {
    if (out.missing.push(gap)) return true;
    out.known_end = gap.begin;  // says nothing about the rest
    return false;
  });
}

std::uint64_t Stream::missing() const { return known_.count_missing(start_, known_.end()); }

}  // namespace srd::host
