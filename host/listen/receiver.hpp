// SPDX-License-Identifier: Apache-2.0
// The host's half of the delivery: datagrams in, frames in order and acknowledgements out, for any number of nodes.
//
// A state machine without socket, clock or file: time is an argument (ns, any steady clock). The caller takes ready frames,
// writes them, flushes its coefficient file and only then asks for acknowledgements: they say that all frames taken so far are safe.
// Memory is bounded whatever comes: so many boots, so many frames waiting behind gaps. One thread.
//
// With keys nothing counts but what holds under the session of its node (handshakes.hpp), once: a frame or status that comes
// again changes nothing, not even where answers go.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "drivers/net/address.hpp"
#include "host/listen/handshakes.hpp"
#include "host/listen/stream.hpp"
#include "proto/messages.hpp"

namespace srd::host {

// What the receiver knows of one boot of one node.
struct Source {
  Stream stream;
  Address address;  // where its last datagram came from
  std::int64_t first_heard_ns = 0, heard_ns = 0;
  std::uint64_t order = 0;  // in which boots were first heard
  bool answer_due = false;
  bool ended = false;               // it said goodbye and nothing is missing
  std::uint64_t next_sequence = 0;  // the highest number the node has spoken of, plus one
  proto::NodeStatus status{};       // the last
  bool has_status = false;
  // Its node measures no more under this boot: it ends, or an earlier run's frames are delivered.
  [[nodiscard]] bool is_past() const { return has_status && status.state == proto::NodeState::kStopping; }
  bool shares_id = false;  // it measured on long after a younger boot of its node had come: two nodes have one id
};

struct ReceiverCounts {
  std::uint64_t datagrams = 0;
  std::uint64_t rejected = 0;  // not a datagram of a node, or not under its session
  std::uint64_t no_room = 0;   // from more boots than are kept
};

// Why a node's datagrams are not accepted. What is said of a node here nothing has proved.
enum class LinkConcern : std::uint8_t {
  kNodeUnknown,  // it has a key, and this host none for it
  kOtherKey,     // it has another key than this host's for it
  kNodeKeyless,  // it sends without a key, and this host has keys
  kHostKeyless,  // it has a key, and this host has none at all
};

class Receiver {
 public:
  static constexpr std::size_t kMaxConcerns = 32;
  static constexpr std::size_t kMaxSources = 256;
  static constexpr std::size_t kMaxWaiting = 32768;
  // An older boot of a node that came back with a new one so long ago, silent for so long, is over: its gaps are lost.
  static constexpr std::int64_t kSupersededAfter = 5'000'000'000;

  // A node that has come back measures no more under its old boot; so long after, nothing of it is under way either.
  static constexpr std::int64_t kOldBootIsSilentAfter = 2'000'000'000;

  // in_file: what the coefficient file has already, by boot. session: random. keys: none on a link without keys.
  Receiver(std::map<proto::BootId, SequenceSet> in_file, std::uint64_t session, KeysOfNode keys = {})
      : in_file_(std::move(in_file)), session_(session) {
    if (keys) handshakes_.emplace(std::move(keys), session);
  }

  void receive(std::span<const std::uint8_t> datagram, const Address& from, std::int64_t now);

  struct Ready {
    proto::BootId from;
    std::uint64_t sequence = 0;
    const proto::CoefficientFrame* frame = nullptr;  // until pop_ready or receive
  };
  // The next frame to write; pop_ready when it is written.
  [[nodiscard]] std::optional<Ready> ready();
  void pop_ready();

  // Ends what is over; call now and then.
  void tick(std::int64_t now);
  // Nothing more will be received: frames behind gaps become ready, the gaps are lost.
  void give_up();

  // Only after all frames taken so far are flushed: what to send, to everyone heard since the last time, or to everyone.
  [[nodiscard]] std::vector<std::pair<Address, std::vector<std::uint8_t>>> acknowledgements(bool to_everyone = false);
  [[nodiscard]] bool answer_due() const { return answer_due_; }
  // Answers to hellos, to send at once.
  [[nodiscard]] std::vector<std::pair<Address, std::vector<std::uint8_t>>> take_welcomes() {
    return std::exchange(welcomes_, {});
  }

  [[nodiscard]] const std::map<proto::BootId, Source>& sources() const { return sources_; }
  [[nodiscard]] const ReceiverCounts& counts() const { return counts_; }
  // As they were found out, at most kMaxConcerns.
  [[nodiscard]] const std::vector<std::pair<proto::NodeId, LinkConcern>>& concerns() const { return concerns_; }
  // Boots of two nodes that measure under one id, the older first, as they were found out. Frames of both are delivered.
  [[nodiscard]] const std::vector<std::pair<proto::BootId, proto::BootId>>& shared_ids() const { return shared_ids_; }

 private:
  std::optional<proto::NodeMessage> opened(std::span<const std::uint8_t> datagram, const Address& from, std::int64_t now);
  void concern(const proto::NodeId& node, LinkConcern what);
  Source* source_of(const proto::NodeHeader& header, std::int64_t now);
  void look_for_namesake(const proto::BootId& id, Source& source, std::int64_t now);

  std::map<proto::BootId, SequenceSet> in_file_;
  std::map<proto::BootId, Source> sources_;
  std::uint64_t session_;
  std::uint64_t serial_ = 0;
  std::optional<Handshakes> handshakes_;  // none: a link without keys
  std::vector<std::pair<Address, std::vector<std::uint8_t>>> welcomes_;
  std::vector<std::pair<proto::NodeId, LinkConcern>> concerns_;
  std::uint64_t heard_sources_ = 0;
  std::size_t waiting_ = 0;
  bool answer_due_ = false;
  proto::BootId turn_;  // whose frame is ready next
  ReceiverCounts counts_;
  std::vector<std::pair<proto::BootId, proto::BootId>> shared_ids_;
};

}  // namespace srd::host
