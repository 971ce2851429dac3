#include "firmware/transmit/transmitter.hpp"

#include <array>
#include <chrono>

#include "drivers/support/system_clock.hpp"
#include "firmware/service/stop_signals.hpp"

namespace srd::firmware {
namespace {

constexpr std::chrono::milliseconds kTurn{2};
constexpr int kMostPerTurn = 32;  // datagrams: a burst that the host's socket buffer holds
constexpr std::chrono::seconds kAgain{1};  // between two tries to reach the host, or to learn its address
constexpr std::int64_t kReconnect = std::chrono::nanoseconds(kAgain).count();

}  // namespace

Transmitter::Transmitter(const TransmitterOptions& options)
    : sender_(options.sender), frames_(options.queue_frames), statuses_(4) {}

Outcome<std::unique_ptr<Transmitter>> Transmitter::start(const TransmitterOptions& options) {
  const auto host = HostAndPort::parse(options.host, {});
  if (!host) return host.error();
  std::unique_ptr<Transmitter> made(new Transmitter(options));
  const StopSignalsBlocked blocked;
  made->host_ = Address::numeric(*host);
  if (!made->host_) {
    made->lookup_.emplace(options.host, options.resolve, kAgain);
  } else if (auto socket = UdpSocket::connect(*made->host_); socket.ok()) {
    made->socket_.emplace(std::move(*socket));
  } else {
    // Binding to no address shows whether this system has the address family at all.
    const auto any = Address::parse(made->host_->family() == AF_INET6 ? "[::]:0" : "0.0.0.0:0", {});
    if (!any.ok() || !UdpSocket::bind(*any).ok()) return socket.error();
  }
  made->thread_ = std::thread([transmitter = made.get()] { transmitter->run(); });
  return made;
}

Transmitter::~Transmitter() {
  abandoned_.store(true);
  if (thread_.joinable()) thread_.join();
}

bool Transmitter::push_waiting(const proto::CoefficientFrame& frame, const std::atomic<bool>& cancelled) noexcept {
  for (;;) {
    if (proto::CoefficientFrame* slot = frames_.back(); slot != nullptr) {
      *slot = frame;
      frames_.push();
      return true;
    }
    if (cancelled.load(std::memory_order_relaxed)) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TransmitterReport Transmitter::finish() {
  stopping_.store(true);
  if (thread_.joinable()) thread_.join();
  // Records that a full ring never took are as good as unacknowledged.
  std::uint64_t queued = 0;
  for (; frames_.front() != nullptr; frames_.pop()) ++queued;
  return {sender_.counts(), sender_.unacknowledged() + queued, frames_.overflow(), ever_heard_, host_problem()};
}

void Transmitter::run() {
  while (!abandoned_.load(std::memory_order_relaxed)) {
    const std::int64_t now = clock_ns(CLOCK_MONOTONIC);
    const bool stopping = stopping_.load(std::memory_order_acquire);
    if (!socket_) connect(now);
    take_records(now);
    if (stopping) sender_.stop(now);
    send_due(now);
    receive(now);
    host_heard_.store(sender_.host_heard(now), std::memory_order_relaxed);
    unacknowledged_.store(sender_.unacknowledged(), std::memory_order_relaxed);
    // Nothing kept and something queued: the queue is taken in the next turn.
    if (stopping && sender_.finished(now) && (frames_.empty() || sender_.unacknowledged() > 0)) break;
  }
  const std::int64_t now = clock_ns(CLOCK_MONOTONIC);
  for (int i = 0; socket_ && stopping_.load() && i < 3; ++i) (void)socket_->send(sender_.status(now));
}

void Transmitter::connect(std::int64_t now) {
  if (!host_) host_ = lookup_->address();
  if (!host_) return;
  if (tried_ns_ != 0 && now - tried_ns_ < kReconnect) return;
  tried_ns_ = now;
  if (auto socket = UdpSocket::connect(*host_); socket.ok()) socket_.emplace(std::move(*socket));
}

void Transmitter::take_records(std::int64_t now) {
  while (const proto::NodeStatus* given = statuses_.front()) {
    proto::NodeStatus status = *given;
    statuses_.pop();
    status.dropped_transmit = frames_.overflow();
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
  for (int i = 0; i < kMostPerTurn; ++i) {
    const auto datagram = sender_.next(now);
    if (datagram.empty()) return;
    // What the system does not take counts as lost on the way.
    if (socket_->send(datagram) == UdpSocket::Sent::kBusy) return;
  }
}

void Transmitter::receive(std::int64_t now) {
  if (!socket_) {
    std::this_thread::sleep_for(kTurn);
    return;
  }
  std::array<std::uint8_t, proto::kMaxDatagram> buffer;
  std::chrono::nanoseconds wait = kTurn;
  for (int i = 0; i < kMostPerTurn; ++i) {
    const std::ptrdiff_t size = socket_->receive(buffer, wait);
    if (size < 0) return;
    wait = std::chrono::nanoseconds(0);
    if (static_cast<std::size_t>(size) > buffer.size()) continue;
    sender_.receive(std::span(buffer).first(static_cast<std::size_t>(size)), now);
    ever_heard_ = ever_heard_ || sender_.counts().acknowledgements > 0;
  }
}

}  // namespace srd::firmware
