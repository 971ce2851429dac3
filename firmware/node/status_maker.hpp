// SPDX-License-Identifier: Apache-2.0
// What the node says of itself each second. One thread; nothing from the heap.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/strobe/scheduler.hpp"
#include "firmware/health/board_health.hpp"
#include "firmware/health/clock_health.hpp"
#include "firmware/loop/frame_loop.hpp"
#include "firmware/recording/frame_recorder.hpp"
#include "proto/messages.hpp"

namespace srd::firmware {

// How the run before this one ended, for the status.
struct Restart {
  std::string last_end;
  std::uint32_t restarts = 0;
};

// Where the board's own state is read; others in tests.
struct HealthSources {
  std::filesystem::path root = "/";
  ClockHealth (*clock)() noexcept = read_clock_health;
};

class StatusMaker {
 public:
  StatusMaker(std::string_view version, const Restart& restart, const HealthSources& sources = {});

  // seconds: since the last call, for the rates. recorder, strobe: may be null.
  [[nodiscard]] proto::NodeStatus make(const FrameLoop& loop, const FrameRecorder* recorder, const StrobeCounters* strobe,
                                       double seconds, bool stopping);

 private:
  proto::NodeStatus constant_;  // what does not change during a run
  BoardHealth health_;
  ClockHealth (*read_clock_)() noexcept;
  std::uint64_t captured_ = 0, records_ = 0;
};

// What systemctl status shows.
[[nodiscard]] std::string status_text(const proto::NodeStatus& status, bool camera_disconnected, bool host_unresolved);

}  // namespace srd::firmware
