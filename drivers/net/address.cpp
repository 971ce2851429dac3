// SPDX-License-Identifier: Apache-2.0
#include "drivers/net/address.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <memory>

#include "drivers/support/text_file.hpp"

namespace srd {
namespace {

Problem not_an_address(std::string_view text, std::string_view where, std::string what) {
  return {.exit = Exit::kUsage,
          .what = std::move(what),
          .where = std::string(where),
          .expected = "HOST:PORT with a port of 1..65535 (0 for any, when binding); IPv6 in brackets",
          .found = "'" + std::string(text) + "'",
          .advice = "127.0.0.1:47810, [::1]:47810 or flume-pc:47810"};
}

}  // namespace

Outcome<HostAndPort> HostAndPort::parse(std::string_view text, std::string_view where) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return not_an_address(text, where, "no port in the address");
  std::string_view host = text.substr(0, colon);
  const std::string_view port_text = text.substr(colon + 1);
  HostAndPort parsed;
  const auto port = parse_number<std::uint16_t>(port_text);
  if (!port) return not_an_address(text, where, "'" + std::string(port_text) + "' is not a port");
  parsed.port = *port;
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  else if (host.find(':') != std::string_view::npos)
    return not_an_address(text, where, "an IPv6 address without brackets");
  if (host.empty()) return not_an_address(text, where, "no host in the address");
  parsed.host = host;
  return parsed;
}

Outcome<Address> Address::parse(std::string_view text, std::string_view where) {
  auto all = parse_all(text, where);
  if (!all) return all.error();
  return all->front();
}

Outcome<std::vector<Address>> Address::parse_all(std::string_view text, std::string_view where) {
  const auto parsed = HostAndPort::parse(text, where);
  if (!parsed) return parsed.error();
  std::vector<Address> addresses;
  if (const int failure = look_up(*parsed, 0, addresses); failure != 0)
    return Problem{.exit = Exit::kNetwork,
                   .what = "cannot resolve '" + parsed->host + "': " + ::gai_strerror(failure),
                   .where = std::string(where),
                   .advice = "a numeric address, or check the name and the network"};
  return addresses;
}

std::optional<Address> Address::numeric(const HostAndPort& of) {
  std::vector<Address> addresses;
  if (look_up(of, AI_NUMERICHOST, addresses) != 0) return std::nullopt;
  return addresses.front();
}

int Address::look_up(const HostAndPort& of, int flags, std::vector<Address>& addresses) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int failure = ::getaddrinfo(of.host.c_str(), std::to_string(of.port).c_str(), &hints, &found); failure != 0)
    return failure;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
    if (entry->ai_family != AF_INET && entry->ai_family != AF_INET6) continue;
    Address address;
    std::copy_n(reinterpret_cast<const char*>(entry->ai_addr), entry->ai_addrlen, reinterpret_cast<char*>(&address.storage_));
    address.size_ = entry->ai_addrlen;
    // A name that stands twice in /etc/hosts has its address twice.
    if (std::find(addresses.begin(), addresses.end(), address) == addresses.end()) addresses.push_back(address);
  }
  return addresses.empty() ? EAI_NONAME : 0;
}

std::string Address::text() const {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (::getnameinfo(get(), size_, host.data(), host.size(), service.data(), service.size(), NI_NUMERICHOST | NI_NUMERICSERV) !=
      0)
    return "(no address)";
  const std::string name = family() == AF_INET6 ? "[" + std::string(host.data()) + "]" : std::string(host.data());
  return name + ":" + service.data();
}

std::uint16_t Address::port() const {
  if (family() == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6*>(&storage_)->sin6_port);
  return ntohs(reinterpret_cast<const sockaddr_in*>(&storage_)->sin_port);
}

bool Address::is_loopback() const {
  if (family() == AF_INET6) return IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6*>(&storage_)->sin6_addr);
  return (ntohl(reinterpret_cast<const sockaddr_in*>(&storage_)->sin_addr.s_addr) >> 24) == 127;
}

bool operator==(const Address& a, const Address& b) {
  if (a.family() != b.family() || a.port() != b.port()) return false;
  if (a.family() == AF_INET6) {
    const auto& x = *reinterpret_cast<const sockaddr_in6*>(&a.storage_);
    const auto& y = *reinterpret_cast<const sockaddr_in6*>(&b.storage_);
    return std::equal(std::begin(x.sin6_addr.s6_addr), std::end(x.sin6_addr.s6_addr), std::begin(y.sin6_addr.s6_addr)) &&
           x.sin6_scope_id == y.sin6_scope_id;
  }
  return reinterpret_cast<const sockaddr_in*>(&a.storage_)->sin_addr.s_addr ==
         reinterpret_cast<const sockaddr_in*>(&b.storage_)->sin_addr.s_addr;
}

}  // namespace srd
