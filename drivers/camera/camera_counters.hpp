// SPDX-License-Identifier: Apache-2.0
// What went wrong with a camera since its start. Written by the driver, read by any thread. Frames that the source lost
// are not here: they are gaps in CameraFrame::sequence.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace srd {

[[nodiscard]] inline std::uint64_t value_of(const std::atomic<std::uint64_t>& counter) noexcept {
  return counter.load(std::memory_order_relaxed);
}

struct CameraCounters {
  std::atomic<std::uint64_t> error_buffers{0};     // frames that the device marked as damaged, or gave only a part of
  std::atomic<std::uint64_t> timeouts{0};          // spans without a frame, of a second and four periods at least
  std::atomic<std::uint64_t> disconnects{0};       // times that the device went away, or stood still and was opened again
  std::atomic<std::uint64_t> reconnects{0};        // times that it came back and streamed again
  std::atomic<std::uint64_t> bad_stamps{0};        // frames whose stamp cannot be true: timed by their arrival
  std::atomic<std::uint64_t> requeue_failures{0};  // buffers that the device did not take back at once

  [[nodiscard]] bool any() const {
    return value_of(error_buffers) + value_of(timeouts) + value_of(disconnects) + value_of(bad_stamps) +
               value_of(requeue_failures) >
           0;
  }
  // "3 error buffers, 1 timeout, 2 disconnects, 2 reconnects"; empty when there is nothing to say.
  [[nodiscard]] std::string text() const {
    std::string out;
    const auto say = [&](const std::atomic<std::uint64_t>& counter, const char* what) {
      const std::uint64_t n = value_of(counter);
      if (n == 0) return;
      out += (out.empty() ? "" : ", ") + std::to_string(n) + " " + what + (n == 1 ? "" : "s");
    };
    say(error_buffers, "error buffer");
    say(timeouts, "timeout");
    say(disconnects, "disconnect");
    say(reconnects, "reconnect");
    say(bad_stamps, "impossible time stamp");
    say(requeue_failures, "failed requeue");
    return out;
  }
};

inline void count_one(std::atomic<std::uint64_t>& counter) noexcept { counter.fetch_add(1, std::memory_order_relaxed); }

}  // namespace srd
