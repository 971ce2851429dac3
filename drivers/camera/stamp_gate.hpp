// SPDX-License-Identifier: Apache-2.0
// Whether a driver's monotonic stamp can be true, judged by when its frame arrived. One that cannot is replaced by the
// arrival, so that no frame carries a time at which its light cannot have fallen. Integers; no heap; one thread.
//
// A frame's stamp is true only if it is positive, not after the arrival by more than a period (drivers that compute the end of
// a frame, as vivid does, hand it over before that), after every time given before, and not older than
// the last moment at which no finished frame was waiting, less what a driver may take to hand a frame over. Frames that
// waited because nobody took them are old and true: then the queue was not seen empty.
#pragma once

#include <algorithm>
#include <cstdint>

namespace srd {

class StampGate {
 public:
  static constexpr std::int64_t kMinDelay = 250'000'000;  // exposure, transfer and decoding of a frame, ns
  static constexpr std::int64_t kDelayPeriods = 4;
  // A wait of so long found nothing at its beginning; the call alone is shorter, ns.
  static constexpr std::int64_t kWaited = 1'000'000;

  StampGate() = default;
  explicit StampGate(std::int64_t period_ns)
      : delay_(std::max(kMinDelay, kDelayPeriods * period_ns)), ahead_(std::max<std::int64_t>(period_ns, 0)) {}

  // The stream starts (again) now: no frame is older.
  void begin(std::int64_t now_ns) noexcept { empty_ns_ = now_ns; }
  // A wait for a frame, from one time to the other.
  void waited(std::int64_t from_ns, std::int64_t to_ns) noexcept {
    if (to_ns - from_ns >= kWaited) empty_ns_ = from_ns;
  }
  [[nodiscard]] bool possible(std::int64_t stamp_ns, std::int64_t arrival_ns) const noexcept {
    return stamp_ns > 0 && stamp_ns <= arrival_ns + ahead_ && stamp_ns > given_ns_ && stamp_ns >= empty_ns_ - delay_;
  }
  // The time that the frame was given.
  void gave(std::int64_t time_ns) noexcept { given_ns_ = time_ns; }

 private:
  std::int64_t delay_ = kMinDelay, ahead_ = 0;
  std::int64_t empty_ns_ = 0, given_ns_ = 0;
};

}  // namespace srd
