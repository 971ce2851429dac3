// SPDX-License-Identifier: Apache-2.0
// Page faults of one thread since it settled: in the steady state there should be none.
#pragma once

#include <sys/resource.h>

#include <atomic>
#include <cstdint>

namespace srd::firmware {

class PageFaults {
 public:
  // After so many frames everything that a frame touches has been touched: counts from there.
  static constexpr std::uint32_t kWarmUp = 100;
  explicit PageFaults(std::uint32_t warm_up = kWarmUp) : warm_up_(warm_up) {}

  // By the thread itself, after each frame. No heap, one system call.
  void frame() noexcept {
    if (frames_ > warm_up_) {
      rusage now{};
      if (::getrusage(RUSAGE_THREAD, &now) != 0) return;
      minor_.store(static_cast<std::uint64_t>(now.ru_minflt - settled_.ru_minflt), std::memory_order_relaxed);
      major_.store(static_cast<std::uint64_t>(now.ru_majflt - settled_.ru_majflt), std::memory_order_relaxed);
    } else if (frames_++ == warm_up_) {
      (void)::getrusage(RUSAGE_THREAD, &settled_);
    }
  }

  // From any thread. Minor: memory given without the disk; major: read from it.
  [[nodiscard]] std::uint64_t minor() const noexcept { return minor_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t major() const noexcept { return major_.load(std::memory_order_relaxed); }

 private:
  std::uint32_t warm_up_;
  std::uint32_t frames_ = 0;
  rusage settled_{};
  std::atomic<std::uint64_t> minor_{0}, major_{0};
};

}  // namespace srd::firmware
