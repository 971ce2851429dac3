// SPDX-License-Identifier: Apache-2.0
#include "firmware/realtime/realtime.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/realtime/page_faults.hpp"

namespace srd::firmware {
namespace {

int calls_made = 0;
int last_priority = 0;
bool locked_future = false;
std::vector<int> last_cpus;

constexpr RealtimeCalls kPermitted{[](bool future) { return ++calls_made, locked_future = future, 0; }, [] { return false; },
                                   [](int priority) { return ++calls_made, last_priority = priority, 0; },
                                   [](std::span<const int> cpus) {
                                     ++calls_made;
                                     last_cpus.assign(cpus.begin(), cpus.end());
                                     return 0;
                                   }};
constexpr RealtimeCalls kForbidden{[](bool) { return ENOMEM; }, [] { return true; }, [](int) { return EPERM; },
                                   [](std::span<const int>) { return EINVAL; }};

void enter(Realtime& realtime, ThreadRole role) {
  std::thread([&] { realtime.enter(role); }).join();
}

TEST(Realtime, EachThreadAsksForItsOwnPriorityAndCpus) {
  RealtimeSection section;
  section.process_cpus = {1, 3};
  Realtime realtime(section, true, kPermitted);
  for (const auto& [role, priority] :
       {std::pair{ThreadRole::kCapture, 60}, {ThreadRole::kStrobe, 80}, {ThreadRole::kProcess, 50}}) {
    enter(realtime, role);
    EXPECT_EQ(last_priority, priority);
  }
  EXPECT_EQ(last_cpus, (std::vector<int>{1, 3}));
  locked_future = true;
  realtime.lock();
  EXPECT_FALSE(locked_future) << "under a limit, memory that comes later must not be refused";
  EXPECT_EQ(realtime.notes(), "");
}

TEST(Realtime, WhatIsNotPermittedIsSaidOnceWithWhatToSet) {
  RealtimeSection section;
  section.process_cpus = {700};
  Realtime realtime(section, true, kForbidden);
  enter(realtime, ThreadRole::kCapture);
  enter(realtime, ThreadRole::kProcess);
  realtime.lock();
  const std::string notes = realtime.notes();
  for (const char* part : {"mlockall", "errno 12", "LimitMEMLOCK", "limits.d", "capture 60, process 50", "errno 1)",
                           "LimitRTPRIO", "CAP_SYS_NICE", "process runs on any CPU", "realtime.process_cpus"})
    EXPECT_NE(notes.find(part), std::string::npos) << part << " in:\n" << notes;
  EXPECT_EQ(std::count(notes.begin(), notes.end(), '\n'), 3);
}

TEST(Realtime, ARecordingIsReplayedAsAnOrdinaryProgram) {
  calls_made = 0;
  Realtime realtime({}, false, kPermitted);
  enter(realtime, ThreadRole::kProcess);
  realtime.lock();
  EXPECT_EQ(calls_made, 0);
}

// The system itself, without any right.
TEST(Realtime, GoesOnWithoutPermission) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (::geteuid() == 0 && ::setresuid(65534, 65534, 65534) != 0) ::_exit(2);
    RealtimeSection section;
    section.wanted = true;
    section.lock_memory = false;
    Realtime realtime(section, true);
    realtime.enter(ThreadRole::kCapture);
    ::_exit(realtime.notes().find("capture 60 (pthread_setschedparam") != std::string::npos ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  // A user whose limits permit it needs no note.
  rlimit limit{};
  ::getrlimit(RLIMIT_RTPRIO, &limit);
  if (limit.rlim_cur >= 60) GTEST_SKIP() << "every user of this system may have real-time priority";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(PageFaults, CountsThoseAfterTheFirstFrames) {
  constexpr std::size_t kPages = 64;
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const auto touch = [&] {
    void* memory = ::mmap(nullptr, kPages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(memory, MAP_FAILED);
    (void)::madvise(memory, kPages * page, MADV_NOHUGEPAGE);
    for (std::size_t i = 0; i < kPages; ++i) static_cast<volatile char*>(memory)[i * page] = 1;
    ::munmap(memory, kPages * page);
  };
  PageFaults faults(3);
  for (int i = 0; i < 4; ++i) {
    touch();
    faults.frame();
  }
  EXPECT_LT(faults.minor(), kPages);
  touch();
  faults.frame();
  EXPECT_GE(faults.minor(), kPages);
}

}  // namespace
}  // namespace srd::firmware
