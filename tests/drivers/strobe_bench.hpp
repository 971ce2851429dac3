// SPDX-License-Identifier: Apache-2.0
// A whole strobe in simulated time: sensor, scheduler, line; and what its light did, by the sensor's truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "drivers/strobe/scheduler.hpp"
#include "tests/fakes/recording_line.hpp"
#include "tests/fakes/simulated_sensor.hpp"
#include "tests/fakes/simulated_strobe_clock.hpp"

namespace srd {

// A global shutter whose stamp marks the frame's start: rows integrate in the exposure before it.
inline StrobeTiming timing_of(double period_ns, double exposure_share = 0.3) {
  StrobeTiming timing;
  timing.window_begin_ns = -static_cast<std::int64_t>(exposure_share * period_ns);
  timing.window_end_ns = 0;
  timing.pulse_ns = std::min<std::int64_t>(static_cast<std::int64_t>(period_ns / 20), 500'000);
  timing.jitter_ns = 100'000;
  timing.max_pulse_ns = 2 * timing.pulse_ns;
  timing.max_duty_ppm = 100'000;
  return timing;
}

struct LightSeen {
  std::size_t pulses = 0;
  std::size_t outside = 0;     // not whole in the window of any exposure
  std::size_t doubles = 0;     // second ones in an exposure
  std::size_t lit_frames = 0;  // exposures with a whole pulse
};

class StrobeBench {
 public:
  StrobeBench(const StrobeTiming& timing, const fakes::SimulatedSensor& sensor, const fakes::SleepHabits& sleep,
              std::uint64_t seed = 1)
      : timing_(timing),
        frames_(sensor.frames()),
        clock(seed, sleep),
        line([this] { return clock.time_ns(); }),
        scheduler(timing, &line, nullptr, clock) {
    clock.woken = [this](std::int64_t now) { deliver(now); };
  }

  // Until the last frame's stamp has arrived.
  void run() {
    while (given_ < frames_.size()) step();
  }
  void step() {
    scheduler.step();
    deliver(clock.time_ns());
    take_pulses();
  }

  // Of exposures from .. to (their places in the sensor's list).
  [[nodiscard]] LightSeen light(std::size_t from, std::size_t to) const {
    LightSeen seen;
    std::vector<int> in_frame(frames_.size());
    for (const fakes::Pulse& pulse : line.pulses()) {
      const double begin = static_cast<double>(pulse.on_ns + timing_.delay_ns),
                   end = static_cast<double>(pulse.off_ns + timing_.delay_ns);
      const auto next = std::lower_bound(frames_.begin(), frames_.end(), begin - static_cast<double>(timing_.window_end_ns),
                                         [](const auto& frame, double t) { return frame.truth_ns < t; });
      const auto place = static_cast<std::size_t>(next - frames_.begin());
      if (place < from || place >= to) continue;
      ++seen.pulses;
      if (begin < next->truth_ns + static_cast<double>(timing_.window_begin_ns) ||
          end > next->truth_ns + static_cast<double>(timing_.window_end_ns))
        ++seen.outside;
      else if (++in_frame[place] == 1)
        ++seen.lit_frames;
      else
        ++seen.doubles;
    }
    return seen;
  }
  // Predicted stamps against the truth, for exposures from .. to. ns.
  [[nodiscard]] double phase_rms(std::size_t from, std::size_t to) const {
    double squares = 0;
    std::size_t n = 0;
    for (const StrobePulse& pulse : pulses) {
      const std::size_t place = nearest(static_cast<double>(pulse.stamp_ns));
      if (place < from || place >= to) continue;
      const double error = static_cast<double>(pulse.stamp_ns) - frames_[place].truth_ns;
      squares += error * error;
      ++n;
    }
    return std::sqrt(squares / static_cast<double>(n));  // NaN for none
  }
  [[nodiscard]] std::size_t nearest(double stamp_ns) const {
    const auto next = std::lower_bound(frames_.begin(), frames_.end(), stamp_ns,
                                       [](const auto& frame, double t) { return frame.truth_ns < t; });
    if (next == frames_.end()) return frames_.size() - 1;
    if (next == frames_.begin()) return 0;
    return static_cast<std::size_t>((next->truth_ns - stamp_ns < stamp_ns - (next - 1)->truth_ns ? next : next - 1) -
                                    frames_.begin());
  }
  // Stamps given until the first pulse.
  [[nodiscard]] std::size_t frames_to_light() const {
    if (line.edges().empty()) return frames_.size();
    return static_cast<std::size_t>(std::count_if(frames_.begin(), frames_.end(), [&](const auto& frame) {
      return frame.delivered && frame.arrival_ns <= line.edges().front().time_ns;
    }));
  }

 private:
  void deliver(std::int64_t now) {
    for (; given_ < frames_.size() && frames_[given_].arrival_ns <= now; ++given_)
      if (frames_[given_].delivered) scheduler.offer({frames_[given_].sequence, frames_[given_].stamp_ns, ClockId::kMonotonic});
  }
  void take_pulses() {
    while (const StrobePulse* pulse = scheduler.pulses().front()) {
      pulses.push_back(*pulse);
      scheduler.pulses().pop();
    }
  }

  StrobeTiming timing_;
  std::vector<fakes::SensorFrame> frames_;
  std::size_t given_ = 0;

 public:
  fakes::SimulatedStrobeClock clock;
  fakes::RecordingLine line;
  StrobeScheduler scheduler;
  std::vector<StrobePulse> pulses;
};

}  // namespace srd
