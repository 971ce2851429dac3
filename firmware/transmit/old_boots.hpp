// SPDX-License-Identifier: Apache-2.0
// Boots of this node from before, whose frames are still in files: delivered under those boots, beside the present one. A file
// goes when the host has all of its frames. No socket, no clock. One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/transmit/sender.hpp"
#include "firmware/transmit/spill.hpp"

namespace srd::firmware {

class OldBoots {
 public:
  // Files that stay on the disk, at most; with more the oldest go, unsent, and are told of.
  static constexpr std::size_t kMost = 8;

  OldBoots() = default;
  // spilled: by generation. Those of other nodes than as.from.node are left alone; empty ones go at once. as: key and timing
  // of the senders.
  OldBoots(std::vector<SpilledFrames> spilled, const SenderOptions& as);

  // The next datagram due at time now; valid until the next call. Each boot in its turn.
  [[nodiscard]] std::span<const std::uint8_t> next(std::int64_t now);
  // A datagram from the host; false: for none of these boots.
  bool receive(std::span<const std::uint8_t> datagram, std::int64_t now);

  [[nodiscard]] bool empty() const { return boots_.empty(); }
  // Frames that are not in the host's record.
  [[nodiscard]] std::uint64_t unacknowledged() const;
  // Of the boots at the start: what is delivered, and what had to be given up; empty: nothing was there.
  [[nodiscard]] const std::string& summary() const { return summary_; }

 private:
  struct Boot {
    std::filesystem::path file;
    proto::BootId id;
    std::unique_ptr<Sender> sender;
    int goodbyes = 0;  // said after the last acknowledgement
  };
  std::vector<Boot> boots_;
  std::size_t turn_ = 0;
  std::string summary_;
};

}  // namespace srd::firmware
