// SPDX-License-Identifier: Apache-2.0
// The frames of one boot of one node, put back in order: each once, a gap waited for as long as the node can fill it.
// No socket, no clock. One thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "host/listen/sequence_set.hpp"
#include "proto/messages.hpp"

namespace srd::host {

struct StreamCounts {
  std::uint64_t delivered = 0;   // given to the sink
  std::uint64_t duplicates = 0;  // came again after they were here
  std::uint64_t late = 0;        // came after a later one: reordered or sent again
  std::uint64_t lost = 0;        // can never come
  std::uint64_t refused = 0;     // no room to wait in; the node will send them again
};

class Stream {
 public:
  // Frames that wait behind a gap, at most; 1.2 KB each.
  static constexpr std::size_t kMaxWaiting = 8192;
  // Pieces that the set of known frames may fall into.
  static constexpr std::size_t kMaxRanges = 16384;
  static constexpr std::size_t kMaxLostRanges = 1024;

  // in_file: what the coefficient file has already. oldest_held: from the first datagram; frames below are not waited for.
  Stream(SequenceSet in_file, std::uint64_t oldest_held);

  // Whether a frame came before, or can no longer come: take would count it as a duplicate.
  [[nodiscard]] bool knows(std::uint64_t sequence) const { return sequence < start_ || known_.contains(sequence); }
  // room: whether a frame that must wait may be kept.
  void take(std::uint64_t sequence, proto::CoefficientFrame frame, bool room = true);
  // The node says that frames below can no longer come: those not here are lost.
  void give_up_below(std::uint64_t oldest_held);
  // The node names frames it had to overwrite, also from before this host listened.
  void take_lost_ranges(std::span<const proto::SequenceRange> ranges);
  // Nothing will come any more: all gaps are lost, what waits is ready.
  void give_up();

  struct Ready {
    std::uint64_t sequence = 0;
    const proto::CoefficientFrame* frame = nullptr;  // until pop_ready
  };
  // The next frame in order, when nothing before it is missing.
  [[nodiscard]] std::optional<Ready> ready() const;
  void pop_ready();

  // All below are delivered or lost.
  [[nodiscard]] std::uint64_t delivered_below() const;
  // Fills first_missing, known_end, missing; all delivered frames are in the coefficient file, flushed.
  void describe(proto::Acknowledgement& out) const;

  // Frames that are missing below the newest known one.
  [[nodiscard]] std::uint64_t missing() const;
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }
  [[nodiscard]] const StreamCounts& counts() const { return counts_; }
  // Ascending; at most kMaxLostRanges, the rest is only counted.
  [[nodiscard]] const std::vector<proto::SequenceRange>& lost_ranges() const { return lost_; }

 private:
  void lose(proto::SequenceRange range);

  std::uint64_t start_;
  SequenceSet known_;  // in the file, delivered, waiting or lost
  std::map<std::uint64_t, proto::CoefficientFrame> waiting_;
  std::vector<proto::SequenceRange> lost_;
  StreamCounts counts_;
};

}  // namespace srd::host
