// SPDX-License-Identifier: Apache-2.0
// The signals that ask the program to end, which has to switch its lines off first.
#pragma once

#include <signal.h>

#include <array>

namespace srd::firmware {

// A person, systemd, a terminal or connection that is gone (SIGHUP; SIGPIPE: the pipe that is written to).
inline constexpr std::array kStopSignals{SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE};

// SIGHUP and SIGPIPE that are ignored at the start stay so: nohup and systemd mean it.
inline void call_on_stop_signals(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  for (const int signal : kStopSignals) {
    struct sigaction before {};
    ::sigaction(signal, nullptr, &before);
    if (before.sa_handler == SIG_IGN && (signal == SIGHUP || signal == SIGPIPE)) continue;
    ::sigaction(signal, &action, nullptr);
  }
}

// They are for the main thread: threads that start while this lives do not get them. Signals of a fault stay as they are, or
// their handler would not be called.
class StopSignalsBlocked {
 public:
  StopSignalsBlocked() {
    sigset_t signals;
    ::sigemptyset(&signals);
    for (const int signal : kStopSignals) ::sigaddset(&signals, signal);
    ::pthread_sigmask(SIG_BLOCK, &signals, &before_);
  }
  ~StopSignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  StopSignalsBlocked(const StopSignalsBlocked&) = delete;
  StopSignalsBlocked& operator=(const StopSignalsBlocked&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace srd::firmware
