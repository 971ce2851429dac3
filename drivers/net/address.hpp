// SPDX-License-Identifier: Apache-2.0
// "HOST:PORT" of a UDP peer: "192.168.1.20:47810", "[fe80::1%eth0]:47810", "flume-pc.local:47810".
#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/support/problem.hpp"

namespace srd {

// The two parts of such a text. No name is looked up.
struct HostAndPort {
  std::string host;  // IPv6 without its brackets
  std::uint16_t port = 0;
  // kUsage for a text that is no HOST:PORT. where: what the text came from ("--bind", "node.toml:12"), for the Problem.
  [[nodiscard]] static Outcome<HostAndPort> parse(std::string_view text, std::string_view where);
};

// A socket address, IPv4 or IPv6.
class Address {
 public:
  Address() = default;
  // Resolves names, which may block for many seconds; the first of several addresses. kUsage for a text that is no HOST:PORT, kNetwork for a name that cannot
  // be resolved.
  [[nodiscard]] static Outcome<Address> parse(std::string_view text, std::string_view where);
  // All addresses of a name, different ones, in the order in which the system prefers them; at least one. As parse otherwise.
  [[nodiscard]] static Outcome<std::vector<Address>> parse_all(std::string_view text, std::string_view where);
  // Nothing for a name: never waits.
  [[nodiscard]] static std::optional<Address> numeric(const HostAndPort& of);

  [[nodiscard]] std::string text() const;  // numeric, as parse takes it
  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] bool is_loopback() const;
  [[nodiscard]] int family() const { return storage_.ss_family; }

  [[nodiscard]] const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage_); }
  [[nodiscard]] sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage_); }
  [[nodiscard]] socklen_t size() const { return size_; }
  void set_size(socklen_t size) { size_ = size; }
  static constexpr socklen_t kCapacity = sizeof(sockaddr_storage);
  friend bool operator==(const Address& a, const Address& b);

 private:
  // 0, or an error of getaddrinfo.
  [[nodiscard]] static int look_up(const HostAndPort& of, int flags, std::vector<Address>& addresses);

  sockaddr_storage storage_{};
  socklen_t size_ = 0;
};

}  // namespace srd
