// SPDX-License-Identifier: Apache-2.0
// How late a thread woke, in bins that double: below 1 us, 1 to 2, 2 to 4, .. One thread adds, any reads.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>

namespace srd {

class LatenessHistogram {
 public:
  static constexpr std::size_t kBins = 20;  // the last from 2^18 us = 262 ms up

  void add(std::int64_t late_ns) noexcept {
    const std::int64_t late = late_ns < 0 ? 0 : late_ns;
    const auto us = static_cast<std::uint64_t>(late / 1000);
    const std::size_t bin = static_cast<std::size_t>(std::bit_width(us));
    raise(bins_[bin < kBins ? bin : kBins - 1]);
    raise(count_);
    if (late > worst_ns_.load(std::memory_order_relaxed)) worst_ns_.store(late, std::memory_order_relaxed);
  }
  [[nodiscard]] std::uint64_t count() const { return count_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t worst_ns() const { return worst_ns_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t bin(std::size_t i) const { return bins_[i].load(std::memory_order_relaxed); }
  // us; the bin counts what is at least this late.
  [[nodiscard]] static std::uint64_t least_us(std::size_t bin) { return bin == 0 ? 0 : std::uint64_t{1} << (bin - 1); }

  // "<1 us 12, 1- 40, 2- 7, worst 3.1 us"; empty bins are left out.
  [[nodiscard]] std::string text() const {
    std::string out;
    for (std::size_t i = 0; i < kBins; ++i)
      if (bin(i) > 0)
        out += (i == 0 ? std::string("<1 us ") : std::to_string(least_us(i)) + "- ") + std::to_string(bin(i)) + ", ";
    const std::int64_t tenths = worst_ns() / 100;
    return out + "worst " + std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " us";
  }

 private:
  static void raise(std::atomic<std::uint64_t>& counter) {
    counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  std::array<std::atomic<std::uint64_t>, kBins> bins_{};
  std::atomic<std::uint64_t> count_{0};
  std::atomic<std::int64_t> worst_ns_{0};
};

}  // namespace srd
