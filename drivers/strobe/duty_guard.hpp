// SPDX-License-Identifier: Apache-2.0
// Keeps LEDs from overheating: how much light there was, against how much there may be. Integer; one thread.
#pragma once

#include <algorithm>
#include <cstdint>

namespace srd {

// A leaking bucket: light fills it, time empties it at max_duty. In any interval t the light is at most
// room + max_duty t, and one pulse more for one that a delayed thread ended late; that is paid back by pulses withheld.
class DutyGuard {
 public:
  // max_duty_ppm: 1 to 1e6. room_ns: of light at once.
  DutyGuard(std::int64_t max_duty_ppm, std::int64_t room_ns) : max_duty_ppm_(max_duty_ppm), room_ns_(room_ns) {}

  [[nodiscard]] bool allows(std::int64_t now_ns, std::int64_t pulse_ns) {
    leak(now_ns);
    return level_ppm_ns_ / kMillion + pulse_ns <= room_ns_;
  }
  // A pulse has ended.
  void add(std::int64_t now_ns, std::int64_t light_ns) {
    leak(now_ns);
    level_ppm_ns_ += std::clamp<std::int64_t>(light_ns, 0, kLongest) * kMillion;
    level_ppm_ns_ = std::min(level_ppm_ns_, kLongest * kMillion);
  }

 private:
  static constexpr std::int64_t kMillion = 1'000'000;
  static constexpr std::int64_t kLongest = 1'000'000'000'000;  // ns; times a million stays below 2^60

  void leak(std::int64_t now_ns) {
    const std::int64_t passed = std::clamp<std::int64_t>(now_ns - last_ns_, 0, kLongest);
    level_ppm_ns_ = std::max<std::int64_t>(0, level_ppm_ns_ - passed * max_duty_ppm_);
    last_ns_ = now_ns;
  }

  std::int64_t max_duty_ppm_, room_ns_;
  std::int64_t level_ppm_ns_ = 0, last_ns_ = 0;
};

}  // namespace srd
