// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <optional>
#include <random>

#include "drivers/net/udp_socket.hpp"
#include "firmware/config/node_key.hpp"
#include "firmware/doctor/doctor.hpp"
#include "firmware/transmit/sender.hpp"

namespace srd::firmware {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kTurn = std::chrono::milliseconds(20);

std::int64_t now_ns() { return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count(); }

// Time until the host's answer to a status of a node that says goodbye at once; nothing: none came. With a key the answer
// proves that the host has it too.
std::optional<double> answer_ms(UdpSocket& socket, const SenderOptions& as_node, std::chrono::milliseconds patience) {
  Sender sender(as_node);
  sender.stop(now_ns());
  const auto begin = Clock::now();
  std::array<std::uint8_t, proto::kMaxDatagram> buffer{};
  while (Clock::now() - begin < patience) {
    for (auto due = sender.next(now_ns()); !due.empty(); due = sender.next(now_ns())) (void)socket.send(due);
    const std::ptrdiff_t size = socket.receive(buffer, kTurn);
    if (size <= 0 || static_cast<std::size_t>(size) > buffer.size()) continue;
    sender.receive(std::span(buffer).first(static_cast<std::size_t>(size)), now_ns());
    if (sender.counts().acknowledgements > 0) return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  }
  return std::nullopt;
}

// Whether the host can be asked at all.
bool check_key(const NodeConfig& config, Diagnosis& diagnosis, SenderOptions& as_node) {
  const auto key = read_node_key(config);
  if (!key) {
    diagnosis.fail("key", key.error());
    return false;
  }
  as_node.key = *key;
  if (as_node.key)
    diagnosis.ok("key", config.key.string());
  else
    diagnosis.warn("key", "none: anyone on this network can send in this node's name, or answer in the host's",
                   "srd keygen " + config.node_id + " on the host, and node.key = the file here");
  return true;
}

}  // namespace

void check_network(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis) {
  if (config.host.empty()) {
    diagnosis.warn("network", "no host: nothing is sent", "node.host, or --host ADDR:PORT");
    return;
  }
  SenderOptions as_node;
  as_node.from = proto::BootId{*proto::NodeId::make(config.node_id), std::random_device{}()};
  as_node.ring_frames = 16;
  as_node.ring_bytes = 1 << 15;
  if (!check_key(config, diagnosis, as_node)) return;
  const auto hosts = Address::parse_all(config.host, config.file.string());
  if (!hosts) {
    diagnosis.fail("network", hosts.error());
    return;
  }
  // As the node does: each address until one answers.
  std::string ways, silent;
  std::optional<Problem> unreachable;
  std::optional<double> answer;
  for (const Address& host : *hosts) {
    auto socket = UdpSocket::connect(host);
    if (!socket) {
      unreachable = socket.error();
      continue;
    }
    ways = config.host + " is " + host.text() + ", from " + socket->local().text();
    if (answer = answer_ms(*socket, as_node, options.answer_time); answer) break;
    silent += (silent.empty() ? "" : " or ") + host.text();
  }
  if (ways.empty()) {
    Problem problem = *unreachable;
    if (problem.advice.empty()) problem.advice = "'ip route' and the cable: this board knows no way there";
    diagnosis.fail("network", problem);
    return;
  }
  diagnosis.ok("network", ways);
  if (answer)
    diagnosis.ok("host", "srd listen answers within " + std::to_string(static_cast<int>(*answer) + 1) + " ms");
  else
    diagnosis.fail(Exit::kNetwork, "host", "nobody answers at " + silent,
                   as_node.key
                       ? "srd listen there with --bind of that address and port and --keys of a folder with this key, and its "
                         "firewall (UDP)"
                       : "srd listen there with --bind of that address and port, without --keys, and its firewall (UDP)");
}

}  // namespace srd::firmware
