// SPDX-License-Identifier: Apache-2.0
// The thread that delivers a node's records: takes them from the frame loop through a ring, keeps them until the host has
// them (sender.hpp), on disk too where a spill is configured (spill.hpp), and drives one UDP socket. A host with several addresses is
// sent to at each in turn, a second at a time, until one acknowledges; a name is looked up anew when the host has been silent
// for five seconds, for it may have moved. Nothing is allocated between start and finish while the network is there and
// the host has an address.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/net/udp_socket.hpp"
#include "dsp/core/spsc_ring.hpp"
#include "firmware/transmit/host_lookup.hpp"
#include "firmware/transmit/old_boots.hpp"
#include "firmware/transmit/sender.hpp"
#include "proto/messages.hpp"

namespace srd::firmware {

struct TransmitterOptions {
  SenderOptions sender{};  // overwrite = false for sources that can wait
  std::string host{};      // HOST:PORT; a name is looked up until it has an address
  HostLookup::Resolve resolve = Address::parse_all;
  std::size_t queue_frames = 64;  // between the frame loop and this thread
  SpillOptions spill{};           // frames and frame_bytes as the sender's; no folder: frames are in memory alone
};

struct TransmitterReport {
  SenderCounts counts{};
  std::uint64_t unacknowledged = 0;  // kept and not in the host's record
  bool host_heard = false;           // ever
  std::string host_problem{};        // why there was no address to send to; empty: there was one
  std::string host_address{};        // see Transmitter::host_address
  std::uint64_t spilled = 0;         // frames of this run and earlier ones that stay on the disk for the next start
  SpillCounts spill{};
};

class Transmitter {
 public:
  // Starts the thread. A network that is not there yet, and a name that has no address yet, are tried again every second.
  // kUsage when the host is no HOST:PORT, kNetwork when there is no socket at all for this kind of address.
  [[nodiscard]] static Outcome<std::unique_ptr<Transmitter>> start(const TransmitterOptions& options);
  Transmitter(const Transmitter&) = delete;
  Transmitter& operator=(const Transmitter&) = delete;
  // Ends at once, without lingering, when finish() was not called.
  ~Transmitter();

  // --- the frame loop's thread ---
  // Never waits. False when the queue is full.
  bool push(const proto::CoefficientFrame& frame) noexcept { return frames_.try_push(frame); }
  // What the status of each second says; call about once a second, from one thread. The sender's own counts and the stamp
  // but for wall_uncertainty_ns are filled in. Skipped when the last ones are not taken yet.
  void set_status(const proto::NodeStatus& status) noexcept { (void)statuses_.try_push(status); }
  // Lingers up to 5 s for the host's acknowledgements, says goodbye, ends the thread.
  [[nodiscard]] TransmitterReport finish();

  // --- any thread ---
  [[nodiscard]] bool host_heard() const { return host_heard_.load(std::memory_order_relaxed); }  // within the last second
  [[nodiscard]] std::uint64_t unacknowledged() const { return unacknowledged_.load(std::memory_order_relaxed); }
  // What there is to say of the spill at the start: earlier runs that are delivered, or why nothing is kept. Else empty.
  [[nodiscard]] const std::string& spill_note() const { return spill_note_; }
  // Why the spill's disk does not take frames; empty: it does, or there is none.
  [[nodiscard]] std::string spill_problem() const { return spill_ ? spill_->problem() : std::string(); }
  // Why the host's name has no address yet; empty: there is one.
  [[nodiscard]] std::string host_problem() const { return lookup_ ? lookup_->problem() : std::string(); }
  // Of a host with several addresses: which one answers, and what others it has, or that none of them does. Else empty.
  [[nodiscard]] std::string host_address() const;

 private:
  explicit Transmitter(const TransmitterOptions& options);
  void open_spill(const TransmitterOptions& options);
  void run();
  void connect(std::int64_t now);
  void look_again(std::int64_t now);
  void take_records(std::int64_t now);
  void send_due(std::int64_t now);
  void receive(std::int64_t now);

  std::vector<Address> hosts_;
  std::size_t tried_host_ = 0;        // of hosts_: where the socket sends
  std::atomic<int> heard_host_{-1};   // of hosts_: that acknowledged last
  std::optional<HostLookup> lookup_;  // of a name
  Sender sender_;
  std::unique_ptr<SpillFile> spill_;
  OldBoots old_boots_;
  std::string spill_note_;
  SpscRing<proto::CoefficientFrame> frames_;
  SpscRing<proto::NodeStatus> statuses_;
  std::optional<UdpSocket> socket_;
  std::int64_t since_ns_ = 0;                     // of the last try to connect, or of the last answer; 0: never
  bool refused_ = false;                          // by the system, since then
  std::int64_t answered_ns_ = 0, looked_ns_ = 0;  // last answer (or the start), and last look for a host that moved
  bool ever_heard_ = false;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> abandoned_{false};
  std::atomic<bool> host_heard_{false};
  std::atomic<std::uint64_t> unacknowledged_{0};
  std::thread thread_;
};

}  // namespace srd::firmware
