// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/frame_pool.hpp"

#include <thread>

namespace srd {

bool FramePacer::wait(std::int64_t time_ns, std::chrono::nanoseconds timeout) {
  const auto now = std::chrono::steady_clock::now();
  if (!running_) {
    running_ = true;
    origin_ = now;
    first_ns_ = time_ns;
  }
  const auto due = origin_ + std::chrono::nanoseconds(time_ns - first_ns_);
  if (due <= now) return true;
  if (due - now > timeout) {
    std::this_thread::sleep_for(timeout);
    return false;
  }
  std::this_thread::sleep_until(due);
  return true;
}

}  // namespace srd
