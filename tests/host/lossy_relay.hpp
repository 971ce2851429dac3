// SPDX-License-Identifier: Apache-2.0
// A bad network between real sockets on loopback: loses, doubles and delays datagrams in both directions.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <random>
#include <thread>
#include <vector>

#include "drivers/net/udp_socket.hpp"

namespace srd::host::simulated {

class LossyRelay {
 public:
  // Nodes send to address(), the host listens at host.
  LossyRelay(const Address& host, double loss, double duplication, std::chrono::microseconds most_delay, std::uint64_t seed)
      : inner_(UdpSocket::bind(Address::parse("127.0.0.1:0", "test").value()).value()),
        outer_(UdpSocket::connect(host).value()),
        loss_(loss),
        duplication_(duplication),
        most_delay_(most_delay),
        random_(seed),
        thread_([this] { run(); }) {}
  ~LossyRelay() {
    ended_ = true;
    thread_.join();
  }
  [[nodiscard]] Address address() const { return inner_.local(); }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct UnderWay {
    bool to_host;
    std::vector<std::uint8_t> bytes;
  };

  void put(bool to_host, std::span<const std::uint8_t> bytes) {
    std::uniform_real_distribution<double> chance;
    const int copies = chance(random_) < duplication_ ? 2 : 1;
    for (int i = 0; i < copies; ++i) {
      if (chance(random_) < loss_) {
        ++lost_;
        continue;
      }
      const auto delay = most_delay_ * chance(random_);
      under_way_.emplace(Clock::now() + std::chrono::duration_cast<Clock::duration>(delay),
                         UnderWay{to_host, {bytes.begin(), bytes.end()}});
    }
  }

  void run() {
    std::array<std::uint8_t, 2048> buffer;
    while (!ended_) {
      Address from;
      for (auto size = inner_.receive(buffer, std::chrono::milliseconds(1), &from); size >= 0;
           size = inner_.receive(buffer, std::chrono::nanoseconds(0), &from)) {
        node_ = from;
        put(true, std::span(buffer).first(static_cast<std::size_t>(size)));
      }
      for (auto size = outer_.receive(buffer, std::chrono::nanoseconds(0)); size >= 0;
           size = outer_.receive(buffer, std::chrono::nanoseconds(0)))
        put(false, std::span(buffer).first(static_cast<std::size_t>(size)));
      while (!under_way_.empty() && under_way_.begin()->first <= Clock::now()) {
        const UnderWay& datagram = under_way_.begin()->second;
        if (datagram.to_host)
          (void)outer_.send(datagram.bytes);
        else
          (void)inner_.send_to(node_, datagram.bytes);
        under_way_.erase(under_way_.begin());
      }
    }
  }

  UdpSocket inner_, outer_;
  double loss_, duplication_;
  std::chrono::microseconds most_delay_;
  std::mt19937_64 random_;
  std::multimap<Clock::time_point, UnderWay> under_way_;
  Address node_;
  std::uint64_t lost_ = 0;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace srd::host::simulated
