// SPDX-License-Identifier: Apache-2.0
#include "host/listen/receiver.hpp"

#include <algorithm>

#include "proto/host_codec.hpp"

namespace srd::host {

using proto::BootId;
using proto::CoefficientFrame;
using proto::NodeStatus;

Source* Receiver::source_of(const proto::NodeHeader& header, std::int64_t now) {
  const auto found = sources_.find(header.from);
  if (found != sources_.end()) return &found->second;
  if (sources_.size() >= kMaxSources) return nullptr;
  SequenceSet in_file;
  if (const auto before = in_file_.find(header.from); before != in_file_.end()) in_file = std::move(before->second);
  Source source{.stream = Stream(std::move(in_file), header.oldest_held),
                .address = {},
                .first_heard_ns = now,
                .order = heard_sources_++};
  return &sources_.emplace(header.from, std::move(source)).first->second;
}

void Receiver::look_for_namesake(const BootId& id, Source& source, std::int64_t now) {
  if (source.shares_id || source.is_past()) return;
  for (auto at = sources_.lower_bound({id.node, 0}); at != sources_.end() && at->first.node == id.node; ++at) {
    const Source& other = at->second;
    if (other.order <= source.order || other.is_past() || now - other.first_heard_ns < kOldBootIsSilentAfter) continue;
    source.shares_id = true;
    shared_ids_.emplace_back(id, at->first);
    return;
  }
}

void Receiver::concern(const proto::NodeId& node, LinkConcern what) {
  const std::pair found(node, what);
  if (concerns_.size() < kMaxConcerns && std::find(concerns_.begin(), concerns_.end(), found) == concerns_.end())
    concerns_.push_back(found);
}

// The message in a datagram that counts; nothing for a hello, which is answered, and for whatever is to be ignored.
std::optional<proto::NodeMessage> Receiver::opened(std::span<const std::uint8_t> datagram, const Address& from,
                                                   std::int64_t now) {
  const auto envelope = datagram.size() <= proto::kMaxDatagram ? proto::read_envelope(datagram) : std::nullopt;
  const bool hello = envelope && envelope->content == proto::Content::kHello;
  std::optional<proto::NodeMessage> message;
  if (!envelope) {
    ++counts_.rejected;
    return std::nullopt;
  }
  if (!handshakes_) {
    message = proto::decode_node_datagram(datagram);
    if (message && hello) message.reset();
    if (hello && proto::seems_tagged(datagram)) concern(envelope->of.node, LinkConcern::kHostKeyless);
  } else if (!proto::seems_tagged(datagram)) {
    if (proto::decode_node_datagram(datagram)) concern(envelope->of.node, LinkConcern::kNodeKeyless);
  } else if (!hello) {
    message = handshakes_->open(datagram, *envelope, now);
  } else if (auto welcome = handshakes_->answer(datagram, *envelope, now)) {
    if (!welcome->empty()) welcomes_.emplace_back(from, std::move(*welcome));
    return std::nullopt;
  } else {
    concern(envelope->of.node, handshakes_->knows(envelope->of.node) ? LinkConcern::kOtherKey : LinkConcern::kNodeUnknown);
  }
  if (!message) ++counts_.rejected;
  return message;
}

void Receiver::receive(std::span<const std::uint8_t> datagram, const Address& from, std::int64_t now) {
  ++counts_.datagrams;
  auto message = opened(datagram, from, now);
  if (!message) return;
  const proto::NodeHeader& header = message->header;
  Source* source = source_of(header, now);
  if (source == nullptr) {
    ++counts_.no_room;
    return;
  }
  Stream& stream = source->stream;
  // Our acknowledgement may have been lost. Who sends a frame again that came may be someone else than its node.
  if (handshakes_ && std::holds_alternative<CoefficientFrame>(message->content) && stream.knows(header.sequence)) {
    stream.take(header.sequence, {});
    source->answer_due = answer_due_ = true;
    return;
  }
  const std::size_t waited = stream.waiting();
  const std::uint64_t spoken_of = source->next_sequence;
  source->address = from;
  source->heard_ns = now;
  source->answer_due = answer_due_ = true;
  source->ended = false;
  if (auto* frame = std::get_if<CoefficientFrame>(&message->content)) {
    source->next_sequence = std::max(source->next_sequence, header.sequence + 1);
    stream.take(header.sequence, std::move(*frame), waiting_ < kMaxWaiting);
    stream.give_up_below(header.oldest_held);
  } else if (const auto* status = std::get_if<NodeStatus>(&message->content)) {
    source->next_sequence = std::max(source->next_sequence, header.sequence);
    // Lost frames lie below the oldest held.
    for (proto::SequenceRange range : status->lost_ranges) {
      range.end = std::min(range.end, header.oldest_held);
      if (range.begin < range.end) stream.take_lost_ranges({&range, 1});
    }
    stream.give_up_below(header.oldest_held);
    source->ended = status->state == proto::NodeState::kStopping && status->held == 0;
    if (!source->has_status || status->stamp.sensor_time_ns >= source->status.stamp.sensor_time_ns) source->status = *status;
    source->has_status = true;
  }
  if (source->next_sequence > spoken_of) look_for_namesake(header.from, *source, now);
  waiting_ += stream.waiting() - waited;
}

std::optional<Receiver::Ready> Receiver::ready() {
  // One after the other from where the last frame came, so that none has to wait for a busy one.
  auto at = sources_.lower_bound(turn_);
  for (std::size_t i = 0; i < sources_.size(); ++i, ++at) {
    if (at == sources_.end()) at = sources_.begin();
    if (const auto found = at->second.stream.ready()) {
      turn_ = at->first;
      return Ready{at->first, found->sequence, found->frame};
    }
  }
  return std::nullopt;
}

void Receiver::pop_ready() {
  sources_.at(turn_).stream.pop_ready();
  --waiting_;
}

void Receiver::tick(std::int64_t now) {
  for (auto& [id, source] : sources_) {
    if (source.stream.missing() == 0 || now - source.heard_ns < kSupersededAfter) continue;
    // A node that came back says at once what it still has of its earlier boots.
    bool superseded = false;
    for (const auto& [other_id, other] : sources_)
      superseded = superseded ||
                   (other_id.node == id.node && other.order > source.order && now - other.first_heard_ns >= kSupersededAfter);
    if (superseded) source.stream.give_up();
  }
}

void Receiver::give_up() {
  for (auto& [id, source] : sources_) source.stream.give_up();
}

std::vector<std::pair<Address, std::vector<std::uint8_t>>> Receiver::acknowledgements(bool to_everyone) {
  std::vector<std::pair<Address, std::vector<std::uint8_t>>> out;
  for (auto& [id, source] : sources_) {
    if (!source.answer_due && !to_everyone) continue;
    source.answer_due = false;
    const proto::Key* key = handshakes_ ? handshakes_->session_key(id) : nullptr;
    if (handshakes_ && key == nullptr) continue;  // it will say hello
    proto::Acknowledgement acknowledgement;
    acknowledgement.of = id;
    acknowledgement.session = session_;
    acknowledgement.serial = ++serial_;
    source.stream.describe(acknowledgement);
    out.emplace_back(source.address, proto::encode_datagram(acknowledgement, key));
  }
  answer_due_ = false;
  return out;
}

}  // namespace srd::host
