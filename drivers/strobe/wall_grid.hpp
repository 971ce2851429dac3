// SPDX-License-Identifier: Apache-2.0
// Moments of the wall clock that boards share without a word: the multiples of a period since 1970. Integer, pure.
#pragma once

#include <cstdint>

namespace srd {

class WallGrid {
 public:
  // rate: mHz, 1 to 10^7. Rates of whole Hz have a moment at each full second.
  explicit WallGrid(std::int64_t rate_mhz) : rate_mhz_(rate_mhz) {}

  // Moment k, ns since 1970, rounded down: k / rate. k * 1000 < 2^35 s * 2^24: in 64 bits.
  [[nodiscard]] std::int64_t time_ns(std::int64_t k) const {
    return k * 1000 / rate_mhz_ * kSecond + k * 1000 % rate_mhz_ * kSecond / rate_mhz_;
  }
  // The first moment at or after a time >= 0.
  [[nodiscard]] std::int64_t first_from(std::int64_t wall_ns) const {
    std::int64_t k = (wall_ns / kSecond * rate_mhz_ + wall_ns % kSecond * rate_mhz_ / kSecond) / 1000;
    while (time_ns(k) < wall_ns) ++k;
    return k;
  }
  [[nodiscard]] std::int64_t period_ns() const { return 1000 * kSecond / rate_mhz_; }

 private:
  static constexpr std::int64_t kSecond = 1'000'000'000;
  std::int64_t rate_mhz_;
};

}  // namespace srd
