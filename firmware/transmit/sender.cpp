// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/sender.hpp"

#include <algorithm>
#include <cstdlib>

namespace srd::firmware {

using proto::CoefficientFrame;
using proto::SequenceRange;

Sender::Sender(const SenderOptions& options)
    : from_(options.from),
      timing_(options.timing),
      link_(options.from, options.key, options.timing.hello_interval, options.timing.silence),
      window_(std::max(options.window, 1u)),
      overwrite_(options.overwrite),
      store_(options.ring_frames, std::max(options.ring_bytes, proto::kMaxEncoded)) {}

bool Sender::push(const CoefficientFrame& frame) {
  auto size = proto::encode(from_, store_.next(), frame, encoded_);
  if (!size) {
    CoefficientFrame bare = frame;
    bare.status = proto::FrameStatus::kFailed;
    bare.stop = dsp::Stop::kNonFinite;
    bare.coefficients.resize(0);
    bare.information = {};
    bare.mean_error = bare.reprojection_rms_px = 0;
    size = proto::encode(from_, store_.next(), bare, encoded_);
  }
  if (!size || (!overwrite_ && !store_.fits(*size))) {
    ++counts_.refused;
    return false;
  }
  make_room(*size);
  if (!store_.append(std::span(encoded_).first(*size))) {
    ++counts_.refused;
    return false;
  }
  if (spill_ != nullptr) spill_->put(store_.next() - 1, std::span(encoded_).first(*size));
  ++counts_.frames;
  ++unacknowledged_;
  return true;
}

void Sender::restore(const SpilledFrames& spilled) {
  if (spilled.frames.empty()) return;
  // Below the first one everything is in the host's record, or was overwritten, which the file says.
  store_.begin_at(spilled.frames.front().sequence);
  next_unsent_ = store_.oldest();
  status_.lost_ranges = spilled.lost;
  for (const proto::SequenceRange& range : spilled.lost) counts_.lost += range.size();
  for (const SpilledFrames::Frame& frame : spilled.frames) {
    for (; store_.next() < frame.sequence; store_.append_gap()) announce_lost(store_.next());
    if (!store_.append(frame.encoded)) return;
    ++counts_.frames;
    ++unacknowledged_;
  }
  status_.state = proto::NodeState::kStopping;
  restored_ = true;
}

void Sender::make_room(std::size_t bytes) {
  while (!store_.empty() && !store_.fits(bytes)) {
    const std::uint64_t sequence = store_.oldest();
    FrameSlot& slot = store_.slot(sequence);
    if (slot.delivery != Delivery::kDone) {
      if (slot.delivery == Delivery::kInFlight || slot.delivery == Delivery::kOverdue) unlink(store_.index(sequence));
      announce_lost(sequence);
      --unacknowledged_;
    }
    store_.drop_oldest();
  }
  next_unsent_ = std::max(next_unsent_, store_.oldest());
  if (spill_ != nullptr) spill_->release(store_.oldest(), status_.lost_ranges);
}

void Sender::announce_lost(std::uint64_t sequence) {
  ++counts_.lost;
  auto& ranges = status_.lost_ranges;
  if (!ranges.empty() && ranges.back().end == sequence) {
    ++ranges.back().end;
    return;
  }
  if (ranges.full()) {
    // The two that lie closest become one. What lies between them the host has, and it looks at what it lacks only.
    std::size_t closest = 0;
    for (std::size_t i = 1; i + 1 < ranges.size(); ++i)
      if (ranges[i + 1].begin - ranges[i].end < ranges[closest + 1].begin - ranges[closest].end) closest = i;
    ranges[closest].end = ranges[closest + 1].end;
    ranges.erase(closest + 1);
  }
  ranges.push({sequence, sequence + 1});
}

std::int64_t Sender::retry_after(std::int64_t now) const {
  if (!host_heard(now)) return timing_.most_retry;
  if (!answering_time_known_) return timing_.first_retry;
  return std::clamp(answering_ns_ + 4 * answering_spread_ns_, timing_.least_retry, timing_.most_retry);
}

void Sender::expire(std::int64_t now) {
  const std::int64_t retry = retry_after(now);
  while (first_in_flight_ != FrameSlot::kNone && now - store_.at(first_in_flight_).sent_ns >= retry) first_overdue();
}

void Sender::all_overdue() {
  while (first_in_flight_ != FrameSlot::kNone) first_overdue();
}

// Of the frames in flight.
void Sender::first_overdue() {
  const std::uint32_t index = first_in_flight_;
  unlink(index);
  link_overdue(index);
}

std::span<const std::uint8_t> Sender::next(std::int64_t now) {
  if (const auto hello = link_.hello(now, heard_ns_, store_.next(), store_.oldest(), datagram_); !hello.empty()) {
    ++counts_.datagrams;
    return hello;
  }
  if (!link_.open()) return {};
  const bool unheard = restored_ && !heard_;
  const std::int64_t interval = stopping_ || unheard ? timing_.stopping_status_interval : timing_.status_interval;
  if (!status_sent_ || now - status_ns_ >= interval) return status(now);
  if (unheard) return {};
  expire(now);
  if (in_flight_ >= window_) return {};
  // Of a restored boot there are gaps, and frames that the host has from before.
  while (next_unsent_ < store_.next() && store_.slot(next_unsent_).delivery != Delivery::kUnsent) ++next_unsent_;
  const bool fresh = next_unsent_ < store_.next();
  const bool overdue = list_head_ != FrameSlot::kNone && list_head_ != first_in_flight_;
  if (!fresh && !overdue) return {};
  const bool resend = overdue && (!fresh || resend_next_);
  resend_next_ = !resend;
  if (resend) return send_frame(store_.sequence_at(list_head_), now);
  return send_frame(next_unsent_++, now);
}

std::span<const std::uint8_t> Sender::send_frame(std::uint64_t sequence, std::int64_t now) {
  const std::uint32_t index = store_.index(sequence);
  FrameSlot& slot = store_.at(index);
  if (slot.delivery == Delivery::kOverdue) {
    unlink(index);
    slot.resent = true;
    ++counts_.resent;
  }
  slot.delivery = Delivery::kInFlight;
  slot.sent_ns = now;
  link_before(index, FrameSlot::kNone);
  if (first_in_flight_ == FrameSlot::kNone) first_in_flight_ = index;
  ++in_flight_;
  ++counts_.datagrams;
  const auto bytes = store_.bytes(sequence);
  std::copy(bytes.begin(), bytes.end(), datagram_.begin());
  return std::span(datagram_).first(proto::seal(datagram_, bytes.size(), store_.oldest(), link_.key()));
}

void Sender::set_status(const proto::NodeStatus& status, std::int64_t wall_minus_now) {
  const auto ranges = status_.lost_ranges;
  status_ = status;
  status_.lost_ranges = ranges;
  wall_minus_now_ = wall_minus_now;
}

std::span<const std::uint8_t> Sender::status(std::int64_t now) {
  if (!link_.open()) return {};
  status_sent_ = true;
  status_ns_ = now;
  proto::NodeStatus out = status_;
  out.stamp.sensor_time_ns = now;
  out.stamp.clock = ClockId::kMonotonic;
  out.stamp.wall_time_ns = wall_minus_now_ == 0 ? 0 : wall_minus_now_ + now;
  if (stopping_) out.state = proto::NodeState::kStopping;
  out.lost = counts_.lost;
  out.resent = counts_.resent;
  out.held = unacknowledged_;
  auto size = proto::encode(from_, store_.next(), out, datagram_);
  if (!size) {
    // The caller's numbers break a bound: what the sender knows must be said all the same.
    proto::NodeStatus own;
    own.stamp = out.stamp;
    own.state = out.state;
    own.lost = out.lost;
    own.resent = out.resent;
    own.held = out.held;
    own.lost_ranges = out.lost_ranges;
    size = proto::encode(from_, store_.next(), own, datagram_);
    if (!size) return {};
  }
  ++counts_.datagrams;
  return std::span(datagram_).first(proto::seal(datagram_, *size, store_.oldest(), link_.key()));
}

void Sender::receive(std::span<const std::uint8_t> datagram, std::int64_t now) {
  if (link_.take_welcome(datagram, now)) {
    all_overdue();  // what is under way ends under another session's key
    return;
  }
  const auto heard = link_.open() ? proto::decode_acknowledgement(datagram, link_.key()) : std::nullopt;
  if (!heard || heard->of != from_ || heard->known_end > (restored_ ? store_.next() : next_unsent_)) {
    ++counts_.ignored;
    return;
  }
  const bool stale = heard_ && heard->session == session_ && heard->serial <= serial_;
  if (stale && link_.keyed()) {  // late, or sent again by someone else: a younger one said more
    ++counts_.ignored;
    return;
  }
  // What is in a record stays there; the rest is the newest word only.
  mark_received(0, heard->first_missing, Delivery::kDone, now);
  if (!stale) {
    // A host that started anew has nothing but its record.
    if (heard_ && heard->session != session_) mark_missing(heard->first_missing, store_.next(), now);
    std::uint64_t at = heard->first_missing;
    for (const SequenceRange& range : heard->missing) {
      mark_received(at, range.begin, Delivery::kReceived, now);
      mark_missing(range.begin, range.end, now);
      at = range.end;
    }
    mark_received(at, heard->known_end, Delivery::kReceived, now);
    session_ = heard->session;
    serial_ = heard->serial;
  }
  heard_ = true;
  heard_ns_ = now;
  ++counts_.acknowledgements;
  release_done();
}

// RFC 6298 (2), on frames that were sent once only (Karn).
void Sender::answered(FrameSlot& slot, std::int64_t now) {
  if (slot.delivery != Delivery::kInFlight || slot.resent) return;
  const std::int64_t sample = now - slot.sent_ns;
  if (!answering_time_known_) {
    answering_ns_ = sample;
    answering_spread_ns_ = sample / 2;
    answering_time_known_ = true;
  } else {
    answering_spread_ns_ += (std::abs(answering_ns_ - sample) - answering_spread_ns_) / 4;
    answering_ns_ += (sample - answering_ns_) / 8;
  }
}

void Sender::mark_received(std::uint64_t begin, std::uint64_t end, Delivery delivery, std::int64_t now) {
  for (std::uint64_t s = std::max(begin, store_.oldest()); s < std::min(end, store_.next()); ++s) {
    FrameSlot& slot = store_.slot(s);
    if (slot.delivery == Delivery::kDone || slot.delivery == delivery) continue;
    answered(slot, now);
    if (slot.delivery == Delivery::kInFlight || slot.delivery == Delivery::kOverdue) unlink(store_.index(s));
    slot.delivery = delivery;
    if (delivery == Delivery::kDone) --unacknowledged_;
  }
}

void Sender::mark_missing(std::uint64_t begin, std::uint64_t end, std::int64_t now) {
  const std::int64_t patience = std::max(timing_.least_retry, answering_ns_);
  for (std::uint64_t s = std::max(begin, store_.oldest()); s < std::min(end, store_.next()); ++s) {
    FrameSlot& slot = store_.slot(s);
    const std::uint32_t index = store_.index(s);
    // Sent a moment ago: the host may have said this before it came.
    if (slot.delivery == Delivery::kInFlight && now - slot.sent_ns < patience) continue;
    if (slot.delivery != Delivery::kInFlight && slot.delivery != Delivery::kReceived) continue;
    if (slot.delivery == Delivery::kInFlight) unlink(index);
    link_overdue(index);
  }
}

void Sender::release_done() {
  while (!store_.empty() && store_.slot(store_.oldest()).delivery == Delivery::kDone) store_.drop_oldest();
  next_unsent_ = std::max(next_unsent_, store_.oldest());
  if (spill_ != nullptr) spill_->release(store_.oldest(), status_.lost_ranges);
}

// Oldest first, or nearly: the host can record nothing before the oldest. After an outage the list is long, and a frame
// that was lost again belongs to its front, a new one to its end; the walk to its place is short and bounded.
void Sender::link_overdue(std::uint32_t index) {
  constexpr int kMaxSteps = 256;
  FrameSlot& slot = store_.at(index);
  const std::uint64_t sequence = store_.sequence_at(index);
  std::uint32_t successor = first_in_flight_;
  if (slot.resent) {
    successor = list_head_;
    for (int i = 0; i < kMaxSteps && successor != first_in_flight_ && store_.sequence_at(successor) < sequence; ++i)
      successor = store_.at(successor).after;
  } else {
    const auto last_before = [this](std::uint32_t s) { return s == FrameSlot::kNone ? list_tail_ : store_.at(s).before; };
    for (int i = 0; i < kMaxSteps; ++i) {
      const std::uint32_t before = last_before(successor);
      if (before == FrameSlot::kNone || store_.sequence_at(before) < sequence) break;
      successor = before;
    }
  }
  slot.delivery = Delivery::kOverdue;
  link_before(index, successor);
}

void Sender::link_before(std::uint32_t index, std::uint32_t successor) {
  FrameSlot& slot = store_.at(index);
  slot.after = successor;
  slot.before = successor == FrameSlot::kNone ? list_tail_ : store_.at(successor).before;
  (slot.before == FrameSlot::kNone ? list_head_ : store_.at(slot.before).after) = index;
  (successor == FrameSlot::kNone ? list_tail_ : store_.at(successor).before) = index;
}

void Sender::unlink(std::uint32_t index) {
  FrameSlot& slot = store_.at(index);
  if (slot.delivery == Delivery::kInFlight) --in_flight_;
  if (first_in_flight_ == index) first_in_flight_ = slot.after;
  (slot.before == FrameSlot::kNone ? list_head_ : store_.at(slot.before).after) = slot.after;
  (slot.after == FrameSlot::kNone ? list_tail_ : store_.at(slot.after).before) = slot.before;
  slot.before = slot.after = FrameSlot::kNone;
}

void Sender::stop(std::int64_t now) {
  if (stopping_) return;
  stopping_ = true;
  stopped_ns_ = now;
}

bool Sender::finished(std::int64_t now) const {
  return stopping_ && (unacknowledged_ == 0 || now - stopped_ns_ >= timing_.linger);
}

}  // namespace srd::firmware
