// SPDX-License-Identifier: Apache-2.0
// Nodes, a bad link and a host in simulated time: one step is a millisecond, nothing waits for a real clock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "firmware/transmit/old_boots.hpp"
#include "firmware/transmit/sender.hpp"
#include "host/listen/session.hpp"

namespace srd::host::simulated {

inline constexpr std::int64_t kMillisecond = 1'000'000;
inline constexpr std::int64_t kSecond = 1'000'000'000;

struct LinkFaults {
  double loss = 0;  // of each datagram, in either direction
  double duplication = 0;
  std::int64_t least_delay = kMillisecond;
  std::int64_t most_delay = kMillisecond;  // spread over the interval: datagrams overtake each other
  bool away = false;                       // nothing passes
};

class Link {
 public:
  explicit Link(std::uint64_t seed) : random_(seed) {}
  LinkFaults faults;

  void put(std::span<const std::uint8_t> datagram, std::int64_t now) {
    if (faults.away) return;
    std::uniform_real_distribution<double> chance;
    const int copies = (chance(random_) < faults.duplication) ? 2 : 1;
    for (int i = 0; i < copies; ++i)
      if (chance(random_) >= faults.loss)
        under_way_.emplace(now + std::uniform_int_distribution<std::int64_t>(faults.least_delay, faults.most_delay)(random_),
                           std::vector<std::uint8_t>(datagram.begin(), datagram.end()));
  }
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> take(std::int64_t now) {
    if (under_way_.empty() || under_way_.begin()->first > now) return std::nullopt;
    auto datagram = std::move(under_way_.begin()->second);
    under_way_.erase(under_way_.begin());
    return datagram;
  }

 private:
  std::mt19937_64 random_;
  std::multimap<std::int64_t, std::vector<std::uint8_t>> under_way_;
};

struct SimulatedNode {
  SimulatedNode(const firmware::SenderOptions& options, std::uint64_t seed)
      : sender(options), to_host(seed), to_node(seed + 1) {}
  firmware::Sender sender;
  Link to_host, to_node;
  std::unique_ptr<firmware::SpillFile> spill;  // none: frames are in memory alone
  firmware::OldBoots old;
  double hz = 200;
  std::int64_t started = 0;
  std::uint64_t captured = 0;
  bool capturing = true;
  bool running = true;  // false: its process is gone
  std::uint64_t sent_bytes = 0;
};

// Notes when each frame was captured and when its row came.
struct Row {
  proto::BootId from;
  std::uint64_t sequence = 0;
  std::int64_t captured_ns = 0;
  std::int64_t recorded_ns = 0;
};

// Keeps rows in memory; what is not flushed is gone with it.
class MemorySink final : public FrameSink {
 public:
  MemorySink(std::vector<Row>& record, const std::int64_t& now) : record_(record), now_(now) {}
  Outcome<void> write(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame) override {
    pending_.push_back({from, sequence, frame.stamp.sensor_time_ns, now_});
    return {};
  }
  Outcome<void> flush() override {
    record_.insert(record_.end(), pending_.begin(), pending_.end());
    pending_.clear();
    return {};
  }

 private:
  std::vector<Row>& record_;
  const std::int64_t& now_;
  std::vector<Row> pending_;
};

class Simulation {
 public:
  std::int64_t now = 100 * kSecond;
  std::vector<Row> record;
  std::vector<std::unique_ptr<SimulatedNode>> nodes;
  std::unique_ptr<MemorySink> sink;
  std::unique_ptr<Session> host;
  std::filesystem::path spill_folder;                                             // of all nodes; empty: none
  std::function<void(bool to_host, const std::vector<std::uint8_t>&)> overheard;  // what arrives anywhere
  std::vector<proto::Key> keys;  // that the host accepts of any node; none: a link without keys

  SimulatedNode& add_node(const std::string& name, std::uint64_t boot, firmware::SenderOptions options = {}) {
    options.from = {*proto::NodeId::make(name), boot};
    nodes.push_back(std::make_unique<SimulatedNode>(options, 1000 + boot));
    nodes.back()->started = now;
    if (!spill_folder.empty()) keep_frames(*nodes.back(), options);
    return *nodes.back();
  }

  // Without any warning.
  static void kill_node(SimulatedNode& node) {
    node.running = node.capturing = false;
    node.spill.reset();
    node.old = {};
  }

  // As srd listen --append does: it knows what the record has, and nothing else.
  void start_host() {
    SessionOptions options;
    for (const Row& row : record) options.in_file[row.from].add(row.sequence);
    options.session = ++sessions_;
    if (!keys.empty()) options.keys = [this](const proto::NodeId&) { return keys; };
    options.clock = [this] { return now; };
    sink = std::make_unique<MemorySink>(record, now);
    host = std::make_unique<Session>(std::move(options), std::vector<FrameSink*>{sink.get()});
  }
  // Without any warning.
  void kill_host() {
    host.reset();
    sink.reset();
  }

  static proto::CoefficientFrame frame_at(std::int64_t time) {
    proto::CoefficientFrame frame;
    frame.stamp = {time, ClockId::kMonotonic, 0, 0};
    frame.status = proto::FrameStatus::kOk;
    frame.model.modes = dsp::ModeList::standard(12).value();
    frame.model.lx = frame.model.ly = 200;
    frame.refractive_index = 1.333f;
    frame.coefficients.setConstant(12, 1.25f);
    frame.information.size = 12;
    for (int i = 0; i < 12; ++i) {
      frame.information.scale[static_cast<std::size_t>(i)] = 1;
      frame.information.entries[proto::InformationFactor::index(i, i)] = 32000;
    }
    return frame;
  }

  void step() {
    now += kMillisecond;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      SimulatedNode& node = *nodes[i];
      if (node.running) advance_node(node);
      while (auto datagram = node.to_host.take(now)) {
        if (overheard) overheard(true, *datagram);
        if (host) host->receive(*datagram, address_of(i));
      }
    }
    if (!host) return;
    const auto answers = host->advance();
    // A stranger who repeats a node's last hello is welcomed, and can do nothing with it.
    for (const Answer& answer : answers.value())
      if (answer.to.port() <= nodes.size()) nodes[answer.to.port() - 1]->to_node.put(answer.datagram, now);
  }
  void run(std::int64_t duration) {
    for (const std::int64_t end = now + duration; now < end;) step();
  }
  // Ends capturing and runs until all nodes have ended, as on SIGTERM.
  void end_nodes() {
    for (auto& node : nodes) {
      node->capturing = false;
      node->sender.stop(now);
    }
    const auto any_running = [this] {
      for (const auto& node : nodes)
        if (node->running) return true;
      return false;
    };
    while (any_running()) step();
  }

 private:
  void keep_frames(SimulatedNode& node, const firmware::SenderOptions& options) {
    auto earlier = firmware::SpillFile::read_all(spill_folder);
    const std::uint64_t generation = earlier.empty() ? 1 : earlier.back().generation + 1;
    node.old = firmware::OldBoots(std::move(earlier), options);
    const firmware::SpillOptions spill{
        .folder = spill_folder, .frames = options.ring_frames, .frame_bytes = proto::most_frame_bytes(frame_at(0).model.modes)};
    auto made = firmware::SpillFile::create(spill, options.from, generation);
    node.spill = std::move(*made);
    node.sender.keep_in(node.spill.get());
  }
  void advance_node(SimulatedNode& node) {
    while (node.capturing &&
           node.started + static_cast<std::int64_t>(static_cast<double>(node.captured) * 1e9 / node.hz) <= now) {
      node.sender.push(frame_at(now));
      ++node.captured;
    }
    while (auto datagram = node.to_node.take(now)) {
      if (overheard) overheard(false, *datagram);
      if (!node.old.receive(*datagram, now)) node.sender.receive(*datagram, now);
    }
    for (auto datagram = node.sender.next(now); !datagram.empty(); datagram = node.sender.next(now)) {
      node.sent_bytes += datagram.size();
      node.to_host.put(datagram, now);
    }
    for (int i = 0; i < 4 && !node.old.empty(); ++i) {
      const auto datagram = node.old.next(now);
      if (datagram.empty()) break;
      node.to_host.put(datagram, now);
    }
    if (node.spill) node.spill->tick(now);
    if (node.sender.finished(now)) {
      for (int i = 0; i < 3; ++i)
        if (const auto goodbye = node.sender.status(now); !goodbye.empty()) node.to_host.put(goodbye, now);
      node.running = false;
    }
  }
  // 127.0.0.1 with the node's number as port.
  static Address address_of(std::size_t node) {
    return Address::parse("127.0.0.1:" + std::to_string(node + 1), "simulation").value();
  }

  std::uint64_t sessions_ = 0;
};

}  // namespace srd::host::simulated
