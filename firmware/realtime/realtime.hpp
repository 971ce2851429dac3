// SPDX-License-Identifier: Apache-2.0
// Start-up of a process whose frames must not wait: memory that stays in place, threads that go first, CPUs of their own.
// What the system does not permit is said once, with what to set, and the node goes on without.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "firmware/realtime/realtime_section.hpp"

namespace srd::firmware {

enum class ThreadRole : std::uint8_t { kCapture, kStrobe, kProcess };
inline constexpr int kThreadRoles = 3;
[[nodiscard]] const char* to_string(ThreadRole role);

// What the start-up asks of the system; each gives 0 or an errno. Tests put others in place.
struct RealtimeCalls {
  int (*lock_memory)(bool future);             // what is used of the memory that there is, and that will come; all code
  bool (*may_lock_everything)();               // no limit on locked memory
  int (*set_priority)(int priority);           // of the calling thread, SCHED_FIFO
  int (*set_cpus)(std::span<const int> cpus);  // of the calling thread
};
[[nodiscard]] const RealtimeCalls& system_calls();

class Realtime {
 public:
  // live: the camera does not wait. For others nothing is done unless the file has [realtime].
  Realtime(const RealtimeSection& section, bool live, const RealtimeCalls& calls = system_calls());

  // Before any thread starts: stacks small enough to be locked, one heap for all threads, no huge pages.
  void prepare();
  // First thing in a thread: stack touched, priority and CPUs set.
  void enter(ThreadRole role);
  // When all buffers are reserved and all threads run: memory locked, free memory kept.
  void lock();

  // What was not permitted, a line each; from the main thread, after the threads have entered.
  [[nodiscard]] std::string notes() const;

 private:
  struct Refusal {
    ThreadRole role;
    int priority;  // 0: the CPUs
    int error;
  };
  bool active_;
  RealtimeSection section_;
  const RealtimeCalls& calls_;
  mutable std::mutex mutex_;
  std::vector<Refusal> refusals_;
  int lock_error_ = 0;
};

}  // namespace srd::firmware
