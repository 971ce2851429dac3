// SPDX-License-Identifier: Apache-2.0
// A host that writes to several places may die between two of them. What the nodes send again then, each place gets only where
// it has it not. One thread.
#pragma once

#include <algorithm>
#include <map>
#include <utility>

#include "host/coefficients/frame_sink.hpp"
#include "host/listen/sequence_set.hpp"

namespace srd::host {

using FramesByBoot = std::map<proto::BootId, SequenceSet>;

class Once final : public FrameSink {
 public:
  // sink outlives this. has: what is in it already.
  Once(FrameSink& sink, FramesByBoot has) : sink_(sink), has_(std::move(has)) {}
  [[nodiscard]] Outcome<void> write(const proto::BootId& from, std::uint64_t sequence,
                                    const proto::CoefficientFrame& frame) override {
    const auto found = has_.find(from);
    if (found != has_.end() && found->second.contains(sequence)) return {};
    return sink_.write(from, sequence, frame);
  }
  [[nodiscard]] Outcome<void> flush() override { return sink_.flush(); }

 private:
  FrameSink& sink_;
  FramesByBoot has_;
};

// What is in both.
[[nodiscard]] inline FramesByBoot in_both(const FramesByBoot& a, const FramesByBoot& b) {
  FramesByBoot out;
  for (const auto& [boot, frames] : a) {
    const auto other = b.find(boot);
    if (other == b.end()) continue;
    SequenceSet both;
    auto one = frames.ranges().begin(), two = other->second.ranges().begin();
    while (one != frames.ranges().end() && two != other->second.ranges().end()) {
      both.add({std::max(one->begin, two->begin), std::min(one->end, two->end)});
      if (one->end < two->end)
        ++one;
      else
        ++two;
    }
    if (!both.empty()) out.emplace(boot, std::move(both));
  }
  return out;
}

}  // namespace srd::host
