// SPDX-License-Identifier: Apache-2.0
// Which nodes sent frames and not one surface: at the end nobody should have to find that out from a plot.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/coefficients/frame_sink.hpp"

namespace srd::host {

class SurfaceCount final : public FrameSink {
 public:
  Outcome<void> write(const proto::BootId& from, std::uint64_t /*sequence*/, const proto::CoefficientFrame& frame) override {
    Node& node = nodes_[from.node];
    ++node.statuses[static_cast<std::size_t>(frame.status)];
    node.surfaces += frame.has_surface() ? 1 : 0;
    return {};
  }
  Outcome<void> flush() override { return {}; }

  // A line a node without a surface: "cam-1: no frame has a surface: 12 searching, 1 bad_frame; ..".
  [[nodiscard]] std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    for (const auto& [name, node] : nodes_) {
      if (node.surfaces > 0) continue;
      std::vector<std::pair<std::uint64_t, std::size_t>> counts;
      for (std::size_t i = 0; i < node.statuses.size(); ++i)
        if (node.statuses[i] > 0) counts.emplace_back(node.statuses[i], i);
      std::stable_sort(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
      std::string reasons;
      for (const auto& [n, status] : counts)
        reasons +=
            (reasons.empty() ? "" : ", ") + std::to_string(n) + " " + proto::to_string(static_cast<proto::FrameStatus>(status));
      notes.push_back(std::string(name.view()) + ": no frame has a surface: " + reasons +
                      "; srd-node --doctor there looks at camera, light and pattern");
    }
    return notes;
  }

 private:
  struct Node {
    std::array<std::uint64_t, proto::kFrameStatusCount> statuses{};
    std::uint64_t surfaces = 0;
  };
  std::map<proto::NodeId, Node> nodes_;
};

}  // namespace srd::host
