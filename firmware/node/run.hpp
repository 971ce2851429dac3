// SPDX-License-Identifier: Apache-2.0
// A started camera, its frame loop in two threads, and the calling thread that watches them.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <latch>
#include <string>

#include "firmware/loop/frame_loop.hpp"
#include "firmware/node/notices.hpp"
#include "firmware/node/report.hpp"
#include "firmware/node/start.hpp"
#include "firmware/node/status_maker.hpp"
#include "firmware/realtime/realtime.hpp"
#include "firmware/service/notifier.hpp"
#include "firmware/service/watchdog.hpp"

namespace srd::firmware {

struct RunOptions {
  std::uint64_t frames = 0;  // end after so many records; 0: at the camera's end
  std::string version;       // of the program, for the status
  Restart restart;
  // Lines for a person while the node runs; from the calling thread.
  std::function<void(const std::string& lines)> notify = [](const std::string&) {};
};

class NodeRun {
 public:
  // All but node outlive the run.
  NodeRun(Instrument& instrument, StartedNode node, const RunOptions& options, Realtime& realtime,
          const std::atomic<bool>& stop);

  // Returns when the frames are over or stop has become true, with every record handed on.
  void measure();
  // After measure(): waits for the host, then tells what the run did.
  [[nodiscard]] RunReport report();

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] FrameLoopOptions loop_options() const;
  [[nodiscard]] proto::NodeStatus status_by(StatusMaker& maker, double seconds, bool stopping) const;
  void watch();
  void report_status(bool camera_disconnected);

  Instrument& instrument_;
  Camera& camera_;
  const RunOptions& options_;
  Realtime& realtime_;
  const std::atomic<bool>& stop_;
  StartedNode node_;
  FrameLoop loop_;
  ServiceNotifier service_;
  FrameWatchdog watchdog_;
  Notices notices_;
  StatusMaker status_;
  std::latch entered_;
  std::atomic<int> running_{2};
  Clock::time_point begin_, next_status_;
};

}  // namespace srd::firmware
