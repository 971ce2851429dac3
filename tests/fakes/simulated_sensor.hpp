// SPDX-License-Identifier: Apache-2.0
// A camera's frames as a strobe sees them: when each was truly exposed, and when which stamp arrived. Seeded.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace srd::fakes {

struct SensorFrame {
  std::uint64_t sequence = 0;
  double truth_ns = 0;  // its stamp, without jitter
  std::int64_t stamp_ns = 0;
  std::int64_t arrival_ns = 0;  // when the stamp is at the board
  bool delivered = true;        // false: dropped on the way; its number is a gap
};

struct SensorHabits {
  double period_ns = 20e6;   // true, by the board's clock
  double jitter_ns = 0;      // of a stamp, one standard deviation, white
  double drop_share = 0;     // of frames
  double delay_ns = 1e6;     // from stamp to arrival
  double outlier_share = 0;  // of stamps, that are late by up to a third of a period
};

class SimulatedSensor {
 public:
  explicit SimulatedSensor(std::uint64_t seed, double start_ns = 1e9) : random_(seed), next_ns_(start_ns) {}

  // That many more exposures.
  void run(int frames, const SensorHabits& habits) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    for (int i = 0; i < frames; ++i, next_ns_ += habits.period_ns) {
      SensorFrame frame;
      frame.sequence = next_sequence_++;
      frame.truth_ns = next_ns_;
      double stamp = next_ns_ + habits.jitter_ns * normal(random_);
      if (uniform(random_) < habits.outlier_share) stamp += habits.period_ns * uniform(random_) / 3;
      frame.stamp_ns = std::llround(stamp);
      frame.arrival_ns = std::llround(std::max(stamp, next_ns_) + habits.delay_ns);
      frame.delivered = uniform(random_) >= habits.drop_share;
      frames_.push_back(frame);
    }
  }
  // Nothing is exposed for so long.
  void pause(double ns) { next_ns_ += ns; }
  // Exposures whose stamps never arrive.
  void lose(int frames, SensorHabits habits) {
    habits.drop_share = 1;
    run(frames, habits);
  }
  // Frames that the source loses without counting them.
  void skip_uncounted(int frames, const SensorHabits& habits) { next_ns_ += frames * habits.period_ns; }

  [[nodiscard]] const std::vector<SensorFrame>& frames() const { return frames_; }

 private:
  std::mt19937_64 random_;
  double next_ns_;
  std::uint64_t next_sequence_ = 0;
  std::vector<SensorFrame> frames_;
};

// Deviation of a prediction k frames ahead over that of the stamps, in the steady loop:
// drivers/strobe/phase_lock.hpp.
[[nodiscard]] inline double phase_lock_spread(double k) {
  const double a = 1.0 / 8, b = 1.0 / 256;
  return std::sqrt((2 * a * a + b * (2 - 3 * a) + 2 * k * b * (2 * a - b) + 2 * k * k * b * b) / (a * (4 - 2 * a - b)));
}

}  // namespace srd::fakes
