// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/transmitter.hpp"

#include <array>
#include <chrono>

#include "drivers/support/system_clock.hpp"
#include "firmware/service/stop_signals.hpp"

namespace srd::firmware {
namespace {

constexpr std::chrono::milliseconds kTurn{2};
constexpr int kMaxPerTurn = 32;                     // datagrams: a burst that the host's socket buffer holds
constexpr int kMaxOldPerTurn = 4;                   // of earlier runs
constexpr std::chrono::seconds kAgain{1};           // between two tries to reach the host, or to learn its address
constexpr std::int64_t kRefusedAgain = 50'000'000;  // ns; the least time at an address where nobody listens
constexpr std::int64_t kSilent = 5'000'000'000;     // ns; before the others of a host that was heard are tried
constexpr std::int64_t kReconnect = std::chrono::nanoseconds(kAgain).count();

}  // namespace

Transmitter::Transmitter(const TransmitterOptions& options)
    : sender_(options.sender), frames_(options.queue_frames), statuses_(4) {}

Outcome<std::unique_ptr<Transmitter>> Transmitter::start(const TransmitterOptions& options) {
  const auto host = HostAndPort::parse(options.host, {});
  if (!host) return host.error();
  std::unique_ptr<Transmitter> made(new Transmitter(options));
  const StopSignalsBlocked blocked;
  made->open_spill(options);
  const auto numeric = Address::numeric(*host);
  if (numeric) made->hosts_ = {*numeric};
  if (!numeric) {
    made->lookup_.emplace(options.host, options.resolve, kAgain);
  } else if (auto socket = UdpSocket::connect(*numeric); socket.ok()) {
    made->socket_.emplace(std::move(*socket));
  } else {
    // Binding to no address shows whether this system has the address family at all.
    const auto any = Address::parse(numeric->family() == AF_INET6 ? "[::]:0" : "0.0.0.0:0", {});
    if (!any.ok() || !UdpSocket::bind(*any).ok()) return socket.error();
  }
  made->thread_ = std::thread([transmitter = made.get()] { transmitter->run(); });
  return made;
}

// A disk that takes nothing does not stop the measurement.
void Transmitter::open_spill(const TransmitterOptions& options) {
  if (options.spill.folder.empty()) return;
  auto earlier = SpillFile::read_all(options.spill.folder);
  const std::uint64_t generation = earlier.empty() ? 1 : earlier.back().generation + 1;
  old_boots_ = OldBoots(std::move(earlier), options.sender);
  spill_note_ = old_boots_.summary();
  auto spill = SpillFile::create(options.spill, options.sender.from, generation);
  if (spill) {
    spill_ = std::move(*spill);
    sender_.keep_in(spill_.get());
    return;
  }
  spill_note_ += (spill_note_.empty() ? "" : "; ") + ("frames are kept in memory alone: " + spill.error().what + ": ") +
                 spill.error().where;
}

Transmitter::~Transmitter() {
  abandoned_.store(true);
  if (thread_.joinable()) thread_.join();
}

TransmitterReport Transmitter::finish() {
  stopping_.store(true);
  if (thread_.joinable()) thread_.join();
  // Records that a full ring never took are as good as unacknowledged.
  std::uint64_t queued = 0;
  for (; frames_.front() != nullptr; frames_.pop()) ++queued;
  TransmitterReport report{sender_.counts(), sender_.unacknowledged() + queued, ever_heard_, host_problem(), host_address()};
  report.spilled = (spill_ ? sender_.unacknowledged() : 0) + old_boots_.unacknowledged();
  if (spill_) report.spill = spill_->counts();
  if (spill_ && sender_.unacknowledged() == 0) spill_->remove();
  return report;
}

void Transmitter::run() {
  while (!abandoned_.load(std::memory_order_relaxed)) {
    const std::int64_t now = clock_ns(CLOCK_MONOTONIC);
    const bool stopping = stopping_.load(std::memory_order_acquire);
    connect(now);
    take_records(now);
    if (stopping) sender_.stop(now);
    send_due(now);
    if (spill_) spill_->tick(now);
    receive(now);
    host_heard_.store(sender_.host_heard(now), std::memory_order_relaxed);
    unacknowledged_.store(sender_.unacknowledged(), std::memory_order_relaxed);
    // Nothing kept and something queued: the queue is taken in the next turn.
    if (stopping && sender_.finished(now) && (frames_.empty() || sender_.unacknowledged() > 0)) break;
  }
  const std::int64_t now = clock_ns(CLOCK_MONOTONIC);
  for (int i = 0; socket_ && stopping_.load() && i < 3; ++i)
    if (const auto goodbye = sender_.status(now); !goodbye.empty()) (void)socket_->send(goodbye);
}

// Of a name whose host is silent. The answer to one call is seen by the next.
void Transmitter::look_again(std::int64_t now) {
  if (answered_ns_ == 0 || sender_.host_heard(now)) answered_ns_ = now;
  if (!lookup_ || hosts_.empty() || now - answered_ns_ < kSilent || now - looked_ns_ < kReconnect) return;
  looked_ns_ = now;
  lookup_->again();
  std::vector<Address> found = lookup_->addresses();
  if (found == hosts_) return;
  hosts_ = std::move(found);
  tried_host_ = 0;
  heard_host_.store(-1, std::memory_order_relaxed);
  socket_.reset();
  since_ns_ = 0;
}

// UDP tells of no connection: an address is right once the host acknowledges from it. Until then each one has its second, or
// less where the system says that nobody listens there. A host that was heard may be silent for longer.
void Transmitter::connect(std::int64_t now) {
  look_again(now);
  if (socket_ && sender_.host_heard(now)) {
    since_ns_ = now;
    refused_ = false;
  }
  const bool heard_here = heard_host_.load(std::memory_order_relaxed) == static_cast<int>(tried_host_);
  const std::int64_t patience = !socket_ ? kReconnect : refused_ ? kRefusedAgain : heard_here ? kSilent : kReconnect;
  if (socket_ && hosts_.size() < 2) return;
  if (since_ns_ != 0 && now - since_ns_ < patience) return;
  if (hosts_.empty() && lookup_) hosts_ = lookup_->addresses();
  if (hosts_.empty()) return;
  since_ns_ = now;
  refused_ = false;
  const auto next = [this] { tried_host_ = (tried_host_ + 1) % hosts_.size(); };
  if (socket_) next();
  socket_.reset();
  for (std::size_t i = 0; i < hosts_.size() && !socket_; ++i)
    if (auto socket = UdpSocket::connect(hosts_[tried_host_]); socket.ok())
      socket_.emplace(std::move(*socket));
    else
      next();
}

std::string Transmitter::host_address() const {
  if (!lookup_) return {};
  const std::vector<Address> hosts = lookup_->addresses();
  if (hosts.size() < 2) return {};
  const int heard = heard_host_.load(std::memory_order_relaxed);
  std::string others;
  for (std::size_t i = 0; i < hosts.size(); ++i)
    if (static_cast<int>(i) != heard) others += (others.empty() ? "" : ", ") + hosts[i].text();
  return heard < 0 ? "none of its addresses answers: " + others
                   : hosts[static_cast<std::size_t>(heard)].text() + " answers; it is also " + others;
}

void Transmitter::take_records(std::int64_t now) {
  while (const proto::NodeStatus* given = statuses_.front()) {
    const proto::NodeStatus status = *given;
    statuses_.pop();
    sender_.set_status(status, clock_ns(CLOCK_REALTIME) - now);
  }
  const bool may_overwrite = sender_.overwrites();
  for (const proto::CoefficientFrame* frame = frames_.front(); frame != nullptr; frame = frames_.front()) {
    if (!may_overwrite && sender_.full()) return;  // the frame loop waits
    sender_.push(*frame);
    frames_.pop();
  }
}

void Transmitter::send_due(std::int64_t now) {
  if (!socket_) return;
  // What the system does not take counts as lost on the way.
  const auto sent = [this](std::span<const std::uint8_t> datagram) {
    const UdpSocket::Sent outcome = socket_->send(datagram);
    if (outcome == UdpSocket::Sent::kFailed) refused_ = true;
    return outcome != UdpSocket::Sent::kBusy;
  };
  for (int i = 0; i < kMaxPerTurn; ++i) {
    const auto datagram = sender_.next(now);
    if (datagram.empty()) break;
    if (!sent(datagram)) return;
  }
  for (int i = 0; i < kMaxOldPerTurn && !old_boots_.empty(); ++i) {
    const auto datagram = old_boots_.next(now);
    if (datagram.empty() || !sent(datagram)) return;
  }
}

void Transmitter::receive(std::int64_t now) {
  if (!socket_) {
    std::this_thread::sleep_for(kTurn);
    return;
  }
  std::array<std::uint8_t, proto::kMaxDatagram> buffer;
  std::chrono::nanoseconds wait = kTurn;
  for (int i = 0; i < kMaxPerTurn; ++i) {
    const std::ptrdiff_t size = socket_->receive(buffer, wait);
    if (size < 0) return;
    wait = std::chrono::nanoseconds(0);
    if (static_cast<std::size_t>(size) > buffer.size()) continue;
    const std::uint64_t before = sender_.counts().acknowledgements;
    const auto datagram = std::span(buffer).first(static_cast<std::size_t>(size));
    if (!old_boots_.receive(datagram, now)) sender_.receive(datagram, now);
    if (sender_.counts().acknowledgements > before) heard_host_.store(static_cast<int>(tried_host_), std::memory_order_relaxed);
    ever_heard_ = ever_heard_ || sender_.counts().acknowledgements > 0;
  }
}

}  // namespace srd::firmware
