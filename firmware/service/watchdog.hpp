// SPDX-License-Identifier: Apache-2.0
// Whether the node may say that it is alive: only while frames go all the way through, or while none can be expected and
// the camera is being called. One thread; no clock of its own.
#pragma once

#include <cstdint>

namespace srd::firmware {

class FrameWatchdog {
 public:
  struct Progress {
    std::uint64_t frames = 0;   // that left the loop, as a record or as late
    std::uint64_t calls = 0;    // of the camera, answered or not
    std::uint64_t pending = 0;  // frames that the camera gave and that have not left the loop
    bool disconnected = false;  // the camera is
  };

  // interval_ns: within which the service manager expects a sign of life; 0: it expects none. period_ns: between two frames of this camera;
  // 0: it has no pace of its own, as one that waits for triggers, or a recording.
  FrameWatchdog(std::int64_t interval_ns, std::int64_t period_ns)
      : interval_ns_(interval_ns), may_be_silent_(period_ns == 0 || period_ns > interval_ns / 4) {}

  // True: say now that the node is alive. Ask several times an interval.
  [[nodiscard]] bool due(std::int64_t now_ns, const Progress& progress) {
    if (interval_ns_ == 0) return false;
    const bool calls_suffice = (progress.disconnected || may_be_silent_) && progress.pending == 0;
    if (progress.frames != frames_ || (calls_suffice && progress.calls != calls_)) moved_ = true;
    frames_ = progress.frames;
    calls_ = progress.calls;
    // A quarter of the time: one that is late is still in time.
    if (!moved_ || (alive_sent_ && now_ns - alive_ns_ < interval_ns_ / 4)) return false;
    moved_ = false;
    alive_sent_ = true;
    alive_ns_ = now_ns;
    return true;
  }

 private:
  std::int64_t interval_ns_;
  bool may_be_silent_;
  std::uint64_t frames_ = 0, calls_ = 0;
  bool moved_ = true;  // the start counts
  bool alive_sent_ = false;
  std::int64_t alive_ns_ = 0;
};

}  // namespace srd::firmware
