// SPDX-License-Identifier: Apache-2.0
// A UDP socket. Opening says in a Problem (exit 5) what does not work; sending and receiving do not allocate and not throw.
// One thread at a time, but send and receive may be called from two.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>

#include "drivers/net/address.hpp"
#include "drivers/support/problem.hpp"
#include "drivers/support/unique_fd.hpp"

namespace srd {

class UdpSocket {
 public:
  // Receives from anyone at this address; port 0: any free one, see local(). receive_bytes: buffer asked of the system,
  // which may give less.
  [[nodiscard]] static Outcome<UdpSocket> bind(const Address& local, int receive_bytes = 4 << 20);
  // Sends to and receives from this peer only.
  [[nodiscard]] static Outcome<UdpSocket> connect(const Address& peer);

  enum class Sent : std::uint8_t { kSent, kBusy, kFailed };  // kBusy: the system's buffer is full
  // To the connected peer. Never waits. kFailed also when the peer's host reported that nobody listens.
  [[nodiscard]] Sent send(std::span<const std::uint8_t> datagram) noexcept;
  [[nodiscard]] Sent send_to(const Address& peer, std::span<const std::uint8_t> datagram) noexcept;

  // Waits up to timeout for a datagram and puts it into buffer. Its size (larger than the buffer when it was cut), or -1
  // when none came; errors that a peer reports (connection refused) count as none. from may be null.
  [[nodiscard]] std::ptrdiff_t receive(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout,
                                       Address* from = nullptr) noexcept;

  [[nodiscard]] Address local() const;
  [[nodiscard]] int fd() const { return fd_.get(); }

 private:
  explicit UdpSocket(UniqueFd fd) : fd_(std::move(fd)) {}
  UniqueFd fd_;
};

}  // namespace srd
