// SPDX-License-Identifier: Apache-2.0
// The node's half of the delivery: every frame reaches the host's record once, or the host learns which did not.
//
// A state machine without socket, clock or heap: time is an argument (ns, any steady clock), datagrams go in and out.
// New frames are sent at once; what the host lacks is sent again, when it says so or when it has said nothing for a
// measured answering time (RFC 6298's estimate). At most a window of frames is under way, so that a slow or absent host is
// not flooded. On a keyed link nothing but hellos is sent before there is a session (link_key.hpp), and each datagram is
// tagged as it leaves: a frame that is sent again belongs to the session of then. A frame is kept until the host says that it is in its record; when the ring is full the oldest is
// overwritten and its number announced, or, for sources that can wait, full() says to wait.
// One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "firmware/transmit/frame_store.hpp"
#include "firmware/transmit/link_key.hpp"
#include "firmware/transmit/spill.hpp"
#include "proto/messages.hpp"
#include "proto/node_codec.hpp"

namespace srd::firmware {

// ns.
struct SenderTiming {
  std::int64_t first_retry = 100'000'000;  // before the answering time is known
  std::int64_t least_retry = 30'000'000;
  std::int64_t most_retry = 500'000'000;  // also the interval while the host is silent
  std::int64_t silence = 1'000'000'000;   // without an answer for so long: the host counts as away
  std::int64_t status_interval = 1'000'000'000;
  std::int64_t stopping_status_interval = 100'000'000;
  std::int64_t hello_interval = 200'000'000;  // on a keyed link, until the host answers
  std::int64_t linger = 5'000'000'000;        // for the last acknowledgement
};

struct SenderOptions {
  proto::BootId from{};
  std::optional<proto::Key> key{};  // of this node; none: the link has no keys
  std::size_t ring_frames = 10000;
  std::size_t ring_bytes = 6 << 20;  // 10,000 frames of 12 parameters need 4.5e6
  std::uint32_t window = 128;        // frames under way
  bool overwrite = true;             // false: full() and push() refuse instead
  SenderTiming timing{};
};

struct SenderCounts {
  std::uint64_t frames = 0;     // taken
  std::uint64_t refused = 0;    // could not be encoded, or the ring was full and may not overwrite
  std::uint64_t datagrams = 0;  // given out, of every kind
  std::uint64_t resent = 0;
  std::uint64_t lost = 0;  // overwritten before they were in the host's record
  std::uint64_t acknowledgements = 0;
  std::uint64_t ignored = 0;  // datagrams received that were none, or for another boot, or impossible
};

class Sender {
 public:
  explicit Sender(const SenderOptions& options);

  // Frames are kept in this file too; it outlives the sender. Before the first push.
  void keep_in(SpillFile* spill) { spill_ = spill; }
  // What a file kept of a boot, in place of pushing: numbers that are not there are announced as lost. The ring holds it.
  void restore(const SpilledFrames& spilled);

  // True when push would have to overwrite a frame.
  [[nodiscard]] bool full() const { return !store_.fits(proto::kMaxEncoded); }
  [[nodiscard]] bool overwrites() const { return overwrite_; }
  // Numbers, encodes and keeps a frame. A frame whose numbers break the wire's bounds (a NaN) is kept without its surface,
  // as failed. False: refused, nothing is kept.
  bool push(const proto::CoefficientFrame& frame);

  // The next datagram due at time now, valid until the next call; empty when there is none. Call until empty.
  [[nodiscard]] std::span<const std::uint8_t> next(std::int64_t now);
  // A datagram from the host.
  void receive(std::span<const std::uint8_t> datagram, std::int64_t now);

  // What the next status says beyond what the sender knows itself (lost, resent, held, ranges, stamp).
  // wall_minus_now: wall clock less the clock of now, ns; 0: not known.
  void set_status(const proto::NodeStatus& status, std::int64_t wall_minus_now);
  // A status datagram now; valid until the next call of next or status. Empty while a keyed link has no session.
  [[nodiscard]] std::span<const std::uint8_t> status(std::int64_t now);

  // No more frames will come: status says stopping, and finished() tells when to end: all is acknowledged or 5 s are over.
  void stop(std::int64_t now);
  [[nodiscard]] bool finished(std::int64_t now) const;

  // Frames that are not in the host's record.
  [[nodiscard]] std::uint64_t unacknowledged() const { return unacknowledged_; }
  [[nodiscard]] std::uint64_t next_sequence() const { return store_.next(); }
  [[nodiscard]] std::uint64_t oldest_held() const { return store_.oldest(); }
  [[nodiscard]] const SenderCounts& counts() const { return counts_; }
  [[nodiscard]] bool host_heard(std::int64_t now) const { return heard_ && now - heard_ns_ <= timing_.silence; }

 private:
  void make_room(std::size_t bytes);
  void announce_lost(std::uint64_t sequence);
  void release_done();
  [[nodiscard]] std::int64_t retry_after(std::int64_t now) const;
  void expire(std::int64_t now);
  void all_overdue();
  void first_overdue();
  [[nodiscard]] std::span<const std::uint8_t> send_frame(std::uint64_t sequence, std::int64_t now);
  void answered(FrameSlot& slot, std::int64_t now);
  void mark_received(std::uint64_t begin, std::uint64_t end, Delivery delivery, std::int64_t now);
  void mark_missing(std::uint64_t begin, std::uint64_t end, std::int64_t now);
  // The list of frames sent and not answered: first the overdue ones, oldest first, then those in flight in the order of
  // sending.
  void link_overdue(std::uint32_t index);
  void link_before(std::uint32_t index, std::uint32_t successor);
  void unlink(std::uint32_t index);

  proto::BootId from_;
  SenderTiming timing_;
  LinkKey link_;
  SpillFile* spill_ = nullptr;
  std::uint32_t window_;
  bool overwrite_;
  FrameStore store_;
  std::uint64_t next_unsent_ = 0;
  std::uint64_t unacknowledged_ = 0;
  std::uint32_t list_head_ = FrameSlot::kNone, list_tail_ = FrameSlot::kNone;
  std::uint32_t first_in_flight_ = FrameSlot::kNone;
  std::uint32_t in_flight_ = 0;
  bool resend_next_ = false;  // new and overdue frames take turns when both wait

  bool heard_ = false;
  std::int64_t heard_ns_ = 0;
  bool answering_time_known_ = false;
  std::int64_t answering_ns_ = 0, answering_spread_ns_ = 0;
  std::uint64_t session_ = 0, serial_ = 0;

  proto::NodeStatus status_;
  std::int64_t wall_minus_now_ = 0;
  bool status_sent_ = false;
  std::int64_t status_ns_ = 0;
  bool stopping_ = false;
  bool restored_ = false;  // no frame before the host has heard by a status that this boot measures no more
  std::int64_t stopped_ns_ = 0;

  SenderCounts counts_;
  std::array<std::uint8_t, proto::kMaxDatagram> encoded_{};
  std::array<std::uint8_t, proto::kMaxDatagram> datagram_{};
};

}  // namespace srd::firmware
