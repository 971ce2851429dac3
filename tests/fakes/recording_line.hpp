// SPDX-License-Identifier: Apache-2.0
// An output line that remembers when it was switched. The test's face: edges(), on(), pulses().
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "drivers/strobe/line.hpp"

namespace srd::fakes {

struct Edge {
  std::int64_t time_ns = 0;
  bool on = false;
};

struct Pulse {
  std::int64_t on_ns = 0, off_ns = 0;
};

class RecordingLine final : public OutputLine {
 public:
  // now_ns: the clock that edges are stamped by. Room for edges is reserved: set takes nothing from the heap below it.
  explicit RecordingLine(std::function<std::int64_t()> now_ns, std::size_t room = 1 << 16) : now_ns_(std::move(now_ns)) {
    edges_.reserve(room);
  }
  void set(bool on) noexcept override {
    ++calls_;
    if (on == on_) return;
    on_ = on;
    if (edges_.size() < edges_.capacity()) edges_.push_back({now_ns_(), on});
  }
  [[nodiscard]] std::uint64_t faults() const noexcept override { return 0; }

  [[nodiscard]] bool on() const { return on_; }
  [[nodiscard]] std::uint64_t calls() const { return calls_; }
  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }
  // Whole pulses; one that is still on is left out.
  [[nodiscard]] std::vector<Pulse> pulses() const {
    std::vector<Pulse> pulses;
    for (std::size_t i = 1; i < edges_.size(); ++i)
      if (edges_[i - 1].on && !edges_[i].on) pulses.push_back({edges_[i - 1].time_ns, edges_[i].time_ns});
    return pulses;
  }

 private:
  std::function<std::int64_t()> now_ns_;
  std::vector<Edge> edges_;
  std::uint64_t calls_ = 0;
  bool on_ = false;
};

}  // namespace srd::fakes
