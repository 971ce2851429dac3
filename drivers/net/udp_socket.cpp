// SPDX-License-Identifier: Apache-2.0
#include "drivers/net/udp_socket.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace srd {
namespace {

Problem failed(const char* action, const Address& address, int error, std::string advice = {}) {
  return {.exit = Exit::kNetwork,
          .what = std::string("cannot ") + action + ": " + std::strerror(error),
          .where = address.text(),
          .advice = std::move(advice)};
}

Outcome<UniqueFd> open_socket(const Address& address) {
  UniqueFd fd(::socket(address.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd.valid()) return failed("open a UDP socket", address, errno);
  return fd;
}

UdpSocket::Sent outcome(ssize_t sent) {
  if (sent >= 0) return UdpSocket::Sent::kSent;
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS || errno == EINTR ? UdpSocket::Sent::kBusy
                                                                                       : UdpSocket::Sent::kFailed;
}

}  // namespace

Outcome<UdpSocket> UdpSocket::bind(const Address& local, int receive_bytes) {
  Outcome<UniqueFd> fd = open_socket(local);
  if (!fd) return fd.error();
  // A smaller buffer than asked only means that more is sent again.
  (void)::setsockopt(fd->get(), SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
  if (::bind(fd->get(), local.get(), local.size()) != 0) {
    const int error = errno;
    return failed("listen", local, error,
                  error == EADDRINUSE      ? "another port, or end the program that listens there"
                  : error == EADDRNOTAVAIL ? "an address of this computer ('ip address' lists them)"
                                           : "");
  }
  return UdpSocket(std::move(*fd));
}

Outcome<UdpSocket> UdpSocket::connect(const Address& peer) {
  Outcome<UniqueFd> fd = open_socket(peer);
  if (!fd) return fd.error();
  if (::connect(fd->get(), peer.get(), peer.size()) != 0) return failed("reach", peer, errno);
  return UdpSocket(std::move(*fd));
}

UdpSocket::Sent UdpSocket::send(std::span<const std::uint8_t> datagram) noexcept {
  return outcome(::send(fd_.get(), datagram.data(), datagram.size(), MSG_NOSIGNAL));
}

UdpSocket::Sent UdpSocket::send_to(const Address& peer, std::span<const std::uint8_t> datagram) noexcept {
  return outcome(::sendto(fd_.get(), datagram.data(), datagram.size(), MSG_NOSIGNAL, peer.get(), peer.size()));
}

std::ptrdiff_t UdpSocket::receive(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout, Address* from) noexcept {
  const auto take = [&]() -> ssize_t {
    if (from == nullptr) return ::recv(fd_.get(), buffer.data(), buffer.size(), MSG_TRUNC);
    socklen_t size = Address::kCapacity;
    const ssize_t got = ::recvfrom(fd_.get(), buffer.data(), buffer.size(), MSG_TRUNC, from->get(), &size);
    if (got >= 0) from->set_size(size);
    return got;
  };
  if (const ssize_t got = take(); got >= 0) return got;
  if (timeout.count() <= 0) return -1;
  pollfd waiting{fd_.get(), POLLIN, 0};
  const timespec wait{static_cast<time_t>(timeout.count() / 1000000000), static_cast<long>(timeout.count() % 1000000000)};
  if (::ppoll(&waiting, 1, &wait, nullptr) <= 0) return -1;
  return std::max<ssize_t>(take(), -1);
}

Address UdpSocket::local() const {
  Address address;
  socklen_t size = Address::kCapacity;
  if (::getsockname(fd_.get(), address.get(), &size) == 0) address.set_size(size);
  return address;
}

}  // namespace srd
