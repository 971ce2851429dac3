// SPDX-License-Identifier: Apache-2.0
#include "firmware/realtime/realtime.hpp"

#include <link.h>
#include <linux/capability.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace srd::firmware {

namespace {

// Under a limit on locked memory all of a stack counts, and 8 MiB each, the usual size, would be most of the node's.
constexpr std::size_t kStackBytes = 512 * 1024;
constexpr std::size_t kTouchedBytes = 256 * 1024;

// Code is read in at once and stays. Memory stays from its first use on: to fetch all that libraries have reserved and never
// use would double what the node takes.
int lock_memory(bool future) {
  if (::mlockall(MCL_ONFAULT | (future ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT)) != 0) return errno;
  return ::dl_iterate_phdr(
      [](dl_phdr_info* object, std::size_t, void*) {
        for (int i = 0; i < object->dlpi_phnum; ++i) {
          const auto& segment = object->dlpi_phdr[i];
          if (segment.p_type != PT_LOAD || (segment.p_flags & PF_X) == 0 || (segment.p_flags & PF_W) != 0) continue;
          const auto begin = static_cast<std::uintptr_t>(object->dlpi_addr + segment.p_vaddr);
          if (::mlock(reinterpret_cast<const void*>(begin), segment.p_memsz) != 0) return errno;
        }
        return 0;
      },
      nullptr);
}

bool may_lock_everything() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) return true;
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> sets{};
  return ::syscall(SYS_capget, &header, sets.data()) == 0 && (sets[0].effective & (1u << CAP_IPC_LOCK)) != 0;
}

int set_priority(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
}

int set_cpus(std::span<const int> cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(static_cast<std::size_t>(cpu), &set);
  return ::pthread_setaffinity_np(::pthread_self(), sizeof set, &set);
}

// Pages that the thread will need are there before its first frame.
[[gnu::noinline]] void touch_stack() {
  std::array<volatile char, kTouchedBytes> pages;
  for (std::size_t i = 0; i < pages.size(); i += 4096) pages[i] = 0;
}

std::string error_text(const char* call, int error) {
  return std::string(call) + ": " + std::strerror(error) + ", errno " + std::to_string(error);
}

}  // namespace

const char* to_string(ThreadRole role) {
  switch (role) {
    case ThreadRole::kCapture: return "capture";
    case ThreadRole::kStrobe: return "strobe";
    case ThreadRole::kProcess: return "process";
  }
  return "unknown";
}

const RealtimeCalls& system_calls() {
  static constexpr RealtimeCalls kCalls{lock_memory, may_lock_everything, set_priority, set_cpus};
  return kCalls;
}

Realtime::Realtime(const RealtimeSection& section, bool live, const RealtimeCalls& calls)
    : active_(live || section.wanted), section_(section), calls_(calls) {}

void Realtime::prepare() {
  if (!active_ || !section_.lock_memory) return;
  (void)::mallopt(M_ARENA_MAX, 1);
  // Huge pages are made later, of pages that are in use, locked ones too: whoever touches them meanwhile faults and waits.
  (void)::prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);
  pthread_attr_t attributes;
  if (::pthread_attr_init(&attributes) != 0) return;
  if (::pthread_attr_setstacksize(&attributes, kStackBytes) == 0) (void)::pthread_setattr_default_np(&attributes);
  ::pthread_attr_destroy(&attributes);
}

void Realtime::enter(ThreadRole role) {
  touch_stack();
  if (!active_) return;
  const std::array<int, kThreadRoles> priorities{section_.capture_priority, section_.strobe_priority,
                                                 section_.process_priority};
  const std::array<const std::vector<int>*, kThreadRoles> cpus{&section_.capture_cpus, &section_.strobe_cpus,
                                                               &section_.process_cpus};
  const auto i = static_cast<std::size_t>(role);
  const auto refused = [&](int priority, int error) {
    const std::lock_guard lock(mutex_);
    refusals_.push_back({role, priority, error});
  };
  if (priorities[i] > 0)
    if (const int error = calls_.set_priority(priorities[i]); error != 0) refused(priorities[i], error);
  if (!cpus[i]->empty())
    if (const int error = calls_.set_cpus(*cpus[i]); error != 0) refused(0, error);
}

void Realtime::lock() {
  if (!active_ || !section_.lock_memory) return;
  // What start-up left over goes back once; from then on the heap keeps what it has.
  (void)::malloc_trim(0);
  (void)::mallopt(M_TRIM_THRESHOLD, -1);
  (void)::mallopt(M_MMAP_MAX, 0);
  // Under a limit, memory that comes later would be refused, not only left unlocked.
  lock_error_ = calls_.lock_memory(calls_.may_lock_everything());
}

std::string Realtime::notes() const {
  const std::lock_guard lock(mutex_);
  std::string text;
  if (lock_error_ != 0)
    text += "note      memory is not locked (" + error_text("mlockall", lock_error_) +
            "), page faults can delay frames: LimitMEMLOCK=infinity in the unit, 'memlock unlimited' in "
            "/etc/security/limits.d, or CAP_IPC_LOCK; or realtime.lock_memory = false\n";
  std::string threads;
  int error = 0;
  for (const Refusal& refusal : refusals_) {
    if (refusal.priority == 0) continue;
    threads += (threads.empty() ? "" : ", ") + std::string(to_string(refusal.role)) + " " + std::to_string(refusal.priority);
    error = refusal.error;
  }
  if (!threads.empty())
    text += "note      no real-time priority for " + threads + " (" + error_text("pthread_setschedparam", error) +
            "), other programs can delay frames: LimitRTPRIO=90 in the unit, 'rtprio 90' in /etc/security/limits.d, or "
            "CAP_SYS_NICE; or priority 0 in [realtime]\n";
  for (const Refusal& refusal : refusals_)
    if (refusal.priority == 0)
      text += "note      " + std::string(to_string(refusal.role)) + " runs on any CPU (" +
              error_text("pthread_setaffinity_np", refusal.error) + "): realtime." + to_string(refusal.role) +
              "_cpus names CPUs that this system or its unit does not give; 'nproc --all' counts them from 0\n";
  return text;
}

}  // namespace srd::firmware
