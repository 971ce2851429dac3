// SPDX-License-Identifier: Apache-2.0
// Simulated time: it passes by being slept, with a lateness, and a little whenever it is read. Seeded.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "drivers/strobe/strobe_clock.hpp"

namespace srd::fakes {

struct SleepHabits {
  double late_ns = 10e3;     // mean of an exponential
  double delayed_share = 0;  // of sleeps, that end up to delayed_ns late
  double delayed_ns = 0;
};

class SimulatedStrobeClock final : public StrobeClock {
 public:
  static constexpr std::int64_t kReadingNs = 200;

  explicit SimulatedStrobeClock(std::uint64_t seed, const SleepHabits& habits = {}, std::int64_t now_ns = 0)
      : random_(seed), habits_(habits), now_(now_ns) {}

  std::int64_t now_ns() noexcept override { return now_ += kReadingNs; }
  void sleep_until(std::int64_t monotonic_ns) noexcept override {
    if (monotonic_ns <= now_) return;
    std::uniform_real_distribution<double> uniform;
    double late = -habits_.late_ns * std::log(1 - uniform(random_));
    if (uniform(random_) < habits_.delayed_share) late += habits_.delayed_ns * uniform(random_);
    now_ = monotonic_ns + static_cast<std::int64_t>(late);
    if (woken) woken(now_);
  }
  std::int64_t offset_ns(ClockId clock) noexcept override {
    return clock == ClockId::kRealtime ? wall_offset_ns : clock == ClockId::kBoottime ? boot_offset_ns : 0;
  }

  [[nodiscard]] std::int64_t time_ns() const { return now_; }  // without passing
  void habits(const SleepHabits& habits) { habits_ = habits; }

  std::function<void(std::int64_t)> woken;  // what the world does meanwhile
  std::int64_t wall_offset_ns = 0, boot_offset_ns = 0;

 private:
  std::mt19937_64 random_;
  SleepHabits habits_;
  std::int64_t now_;
};

}  // namespace srd::fakes
