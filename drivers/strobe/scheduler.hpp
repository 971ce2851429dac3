// SPDX-License-Identifier: Apache-2.0
// Decides when light falls and makes it fall then: pulses in step with a camera (follow), or a camera in step with the
// wall clock (trigger). One thread steps it; stamps come in and pulses go out through rings. While it steps: no
// heap, no lock, no floating point.
#pragma once

#include <atomic>
#include <cstdint>

#include "drivers/strobe/duty_guard.hpp"
#include "drivers/strobe/lateness_histogram.hpp"
#include "drivers/strobe/line.hpp"
#include "drivers/strobe/phase_lock.hpp"
#include "drivers/strobe/strobe_clock.hpp"
#include "drivers/strobe/strobe_pulse.hpp"
#include "drivers/strobe/trigger_watch.hpp"
#include "drivers/strobe/wall_grid.hpp"
#include "dsp/core/spsc_ring.hpp"

namespace srd {

struct StrobeTiming {
  // Light in [begin, end) after a frame's stamp reaches every row of it alike; negative before the stamp.
  std::int64_t window_begin_ns = 0, window_end_ns = 0;
  std::int64_t pulse_ns = 500'000;
  std::int64_t delay_ns = 0;         // from the line to the light
  std::int64_t jitter_ns = 200'000;  // lateness that is allowed for
  std::int64_t max_pulse_ns = 2'000'000;
  std::int64_t max_duty_ppm = 100'000;
  StrobePattern pattern;
  // Trigger mode only.
  std::int64_t trigger_rate_mhz = 0;  // 0: follow
  std::int64_t trigger_pulse_ns = 0;
  std::int64_t stamp_after_trigger_ns = 0;  // from the trigger to the stamp of the frame that it makes
};

// Written by the strobe's thread, read by any.
struct StrobeCounters {
  std::atomic<std::uint64_t> pulses{0};
  std::atomic<std::uint64_t> dark{0};      // exposures left dark on purpose
  std::atomic<std::uint64_t> late{0};      // edges later than jitter_ns
  std::atomic<std::uint64_t> skipped{0};   // pulses left out: the light would have left the window
  std::atomic<std::uint64_t> withheld{0};  // pulses left out: max_duty
  std::atomic<std::uint64_t> overlong{0};  // pulses that a delayed thread ended after max_pulse_ns
  std::atomic<std::uint64_t> spilled{0};   // pulses that it ended after the window
  std::atomic<std::int64_t> longest_ns{0};
  std::atomic<std::uint64_t> triggers{0};
  std::atomic<std::uint64_t> triggers_missed{0};  // without a frame
  std::atomic<std::uint64_t> untriggered{0};      // frames without a trigger
  std::atomic<std::uint64_t> wall_steps{0};       // steps of the wall clock; the grid was found again
  std::atomic<std::uint64_t> unread{0};           // pulses that nobody took
  std::atomic<LockState> lock{LockState::kUnlocked};
  std::atomic<std::uint64_t> rejected{0}, slips{0}, locks{0};  // of the phase lock
  std::atomic<std::int64_t> period_ns{0}, jitter_ns{0}, uncertainty_ns{0};
};

class StrobeScheduler {
 public:
  static constexpr std::int64_t kIdleNs = 5'000'000;    // between looks at the ring while there is nothing to do
  static constexpr std::int64_t kSliceNs = 20'000'000;  // longest sleep: how soon stop() and a stepped clock are seen
  static constexpr std::int64_t kSettleNs = 1'000'000;  // before an edge: the last stamps are taken, then no more
  static constexpr std::int64_t kStepNs = 1'000'000;    // a wall clock that moves this far in a slice has been stepped

  // strobe: null only in trigger mode. trigger: null in follow mode. All outlive the scheduler.
  StrobeScheduler(const StrobeTiming& timing, OutputLine* strobe, OutputLine* trigger, StrobeClock& clock);
  // Lines are low afterwards.
  ~StrobeScheduler() { all_off(); }
  StrobeScheduler(const StrobeScheduler&) = delete;
  StrobeScheduler& operator=(const StrobeScheduler&) = delete;

  // --- the capturing thread ---
  // A full ring drops the stamp: one more frame that the phase lock bridges.
  void offer(const StrobeStamp& stamp) noexcept { (void)stamps_.try_push(stamp); }

  // --- the thread that labels frames ---
  // One for each exposure, ascending.
  [[nodiscard]] SpscRing<StrobePulse>& pulses() { return pulses_; }

  // --- the strobe's thread ---
  // Takes stamps, then sleeps a slice or makes the next pulse.
  void step() noexcept;
  // Steps until stop(), then turns all off.
  void run() noexcept {
    while (!stopping_.load(std::memory_order_relaxed)) step();
    all_off();
  }

  // --- any thread, or a signal handler ---
  void stop() noexcept { stopping_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] const StrobeCounters& counters() const { return counters_; }
  // Follow: of pulses. Trigger: of triggers.
  [[nodiscard]] const LatenessHistogram& lateness() const { return lateness_; }
  // From a frame's stamp to when the line is switched on.
  [[nodiscard]] std::int64_t on_offset_ns() const { return on_offset_ns_; }

 private:
  static constexpr std::size_t kRing = 1024;

  void all_off() noexcept;
  void take_stamps() noexcept;
  void publish(LockState state) noexcept;
  void follow(std::int64_t now_ns) noexcept;
  void trigger(std::int64_t now_ns) noexcept;
  // Switches on at on_ns and off again, and the trigger off, each in its turn. light_end_ns: the window's.
  void flash(std::int64_t on_ns, std::int64_t light_end_ns, std::int64_t trigger_off_ns, StrobePulse& pulse) noexcept;
  void emit(const StrobePulse& pulse) noexcept;

  StrobeTiming timing_;
  OutputLine* strobe_;
  OutputLine* trigger_;
  StrobeClock& clock_;
  SpscRing<StrobeStamp> stamps_{kRing};
  SpscRing<StrobePulse> pulses_{kRing};
  StrobeCounters counters_;
  LatenessHistogram lateness_;
  std::atomic<bool> stopping_{false};

  PhaseLock lock_;
  DutyGuard duty_;
  WallGrid grid_;
  TriggerWatch watch_;
  std::int64_t on_offset_ns_ = 0;
  std::int64_t trust_ns_ = 0;          // three deviations of a prediction may be this much
  std::int64_t sensor_offset_ns_ = 0;  // sensor's clock less monotonic
  std::int64_t last_on_ns_ = 0;        // of the last pulse or trigger planned
  std::int64_t slot_ = 0;
  bool planned_ = false;   // next_ holds
  std::int64_t next_ = 0;  // exposure of the phase lock, or moment of the grid
  std::uint64_t generation_ = 0;
  std::int64_t wall_offset_ns_ = 0;
  bool wall_known_ = false;
};

}  // namespace srd
