// SPDX-License-Identifier: Apache-2.0
// A set of frame numbers as ranges: what a host has of one boot. Small as long as the numbers are mostly together.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "proto/identity.hpp"

namespace srd::host {

class SequenceSet {
 public:
  // Ascending, apart.
  [[nodiscard]] const std::vector<proto::SequenceRange>& ranges() const { return ranges_; }
  [[nodiscard]] bool empty() const { return ranges_.empty(); }
  [[nodiscard]] std::uint64_t end() const { return ranges_.empty() ? 0 : ranges_.back().end; }

  [[nodiscard]] bool contains(std::uint64_t sequence) const {
    const auto after = first_ending_after(sequence);
    return after != ranges_.end() && after->begin <= sequence;
  }

  // Adds all numbers of the range.
  void add(proto::SequenceRange range) {
    if (range.end <= range.begin) return;
    // Ranges that overlap or touch become one.
    auto first = std::lower_bound(ranges_.begin(), ranges_.end(), range.begin,
                                  [](const proto::SequenceRange& r, std::uint64_t begin) { return r.end < begin; });
    auto last = first;
    for (; last != ranges_.end() && last->begin <= range.end; ++last) {
      range.begin = std::min(range.begin, last->begin);
      range.end = std::max(range.end, last->end);
    }
    if (first == last) {
      ranges_.insert(first, range);
    } else {
      *first = range;
      ranges_.erase(first + 1, last);
    }
  }
  void add(std::uint64_t sequence) { add({sequence, sequence + 1}); }

  // Takes a number out that is in the set.
  void remove(std::uint64_t sequence) {
    const auto range = ranges_.begin() + (first_ending_after(sequence) - ranges_.cbegin());
    const proto::SequenceRange whole = *range;
    if (whole.begin == sequence && whole.end == sequence + 1) {
      ranges_.erase(range);
    } else if (whole.begin == sequence) {
      ++range->begin;
    } else if (whole.end == sequence + 1) {
      --range->end;
    } else {
      range->end = sequence;
      ranges_.insert(range + 1, {sequence + 1, whole.end});
    }
  }

  // The first number from start on that is not in the set.
  [[nodiscard]] std::uint64_t first_missing(std::uint64_t start) const {
    const auto after = first_ending_after(start);
    return after != ranges_.end() && after->begin <= start ? after->end : start;
  }

  // Calls use(range) for what [begin, end) lacks, ascending; stops when use returns false.
  template <class Use>
  void for_missing(std::uint64_t begin, std::uint64_t end, Use use) const {
    for (auto range = first_ending_after(begin); begin < end; ++range) {
      const std::uint64_t stop = range == ranges_.end() ? end : std::min(range->begin, end);
      if (begin < stop && !use(proto::SequenceRange{begin, stop})) return;
      if (range == ranges_.end()) return;
      begin = range->end;
    }
  }
  [[nodiscard]] std::uint64_t count_missing(std::uint64_t begin, std::uint64_t end) const {
    std::uint64_t count = 0;
    for_missing(begin, end, [&](const proto::SequenceRange& range) {
      count += range.size();
      return true;
    });
    return count;
  }

 private:
  [[nodiscard]] std::vector<proto::SequenceRange>::const_iterator first_ending_after(std::uint64_t sequence) const {
    return std::upper_bound(ranges_.begin(), ranges_.end(), sequence,
                            [](std::uint64_t s, const proto::SequenceRange& r) { return s < r.end; });
  }
  std::vector<proto::SequenceRange> ranges_;
};

}  // namespace srd::host
