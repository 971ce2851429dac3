// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <optional>
#include <random>

#include "drivers/net/udp_socket.hpp"
#include "firmware/doctor/doctor.hpp"
#include "firmware/transmit/sender.hpp"

namespace srd::firmware {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kRepeat = std::chrono::milliseconds(200);

std::int64_t now_ns() { return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count(); }

// Time until the host's answer to a status of a node that says goodbye at once; nothing: none came.
std::optional<double> answer_ms(UdpSocket& socket, const std::string& node, std::chrono::milliseconds patience) {
  SenderOptions options;
  options.from = proto::BootId{*proto::NodeId::make(node), std::random_device{}()};
  options.ring_frames = 16;
  options.ring_bytes = 1 << 15;
  Sender sender(options);
  sender.stop(now_ns());
  const auto begin = Clock::now();
  std::array<std::uint8_t, proto::kMaxDatagram> buffer{};
  while (Clock::now() - begin < patience) {
    (void)socket.send(sender.status(now_ns()));
    const std::ptrdiff_t size = socket.receive(buffer, kRepeat);
    if (size <= 0 || static_cast<std::size_t>(size) > buffer.size()) continue;
    sender.receive(std::span(buffer).first(static_cast<std::size_t>(size)), now_ns());
    if (sender.counts().acknowledgements > 0) return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  }
  return std::nullopt;
}

}  // namespace

void check_network(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis) {
  if (config.host.empty()) {
    diagnosis.warn("network", "no host: nothing is sent", "node.host, or --host ADDR:PORT");
    return;
  }
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
    if (answer = answer_ms(*socket, config.node_id, options.answer_time); answer) break;
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
                   "srd listen there with --bind of that address and port, and its firewall (UDP)");
}

}  // namespace srd::firmware
