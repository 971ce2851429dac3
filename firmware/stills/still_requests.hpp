// SPDX-License-Identifier: Apache-2.0
// How a person asks for a still: Enter, on a terminal or through a pipe (ssh without one), or SIGUSR1 from anywhere.
#pragma once

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>

namespace srd::firmware {

// One object at a time; asked() on one thread.
class StillRequests {
 public:
  StillRequests() {
    struct sigaction action {};
    action.sa_handler = [](int) { signalled_.store(true, std::memory_order_relaxed); };
    action.sa_flags = SA_RESTART;
    ::sigemptyset(&action.sa_mask);
    ::sigaction(SIGUSR1, &action, nullptr);
  }

  // Whether somebody asked since the last call; does not wait.
  [[nodiscard]] bool asked() {
    const bool line = line_came();
    return signalled_.exchange(false, std::memory_order_relaxed) || line;
  }

 private:
  bool line_came() {
    if (!open_) return false;
    // A job in the background that reads its terminal is stopped by it.
    if (::isatty(STDIN_FILENO) != 0 && ::tcgetpgrp(STDIN_FILENO) != ::getpgrp()) return false;
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, 0) <= 0 || (input.revents & (POLLIN | POLLHUP | POLLERR)) == 0) return false;
    std::array<char, 256> text{};
    const ssize_t size = ::read(STDIN_FILENO, text.data(), text.size());
    if (size <= 0) {
      open_ = false;  // /dev/null, or a connection that is gone: SIGUSR1 and --every go on
      return false;
    }
    return std::find(text.begin(), text.begin() + size, '\n') != text.begin() + size;
  }

  static inline std::atomic<bool> signalled_{false};
  bool open_ = true;
};

}  // namespace srd::firmware
