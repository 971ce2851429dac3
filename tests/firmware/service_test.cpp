// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "firmware/service/last_end.hpp"
#include "firmware/service/notifier.hpp"
#include "firmware/service/watchdog.hpp"
#include "tests/fakes/notify_socket.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

constexpr std::int64_t kOneSecond = 1'000'000'000;

TEST(ServiceNotifier, SpeaksToTheManager) {
  fakes::NotifySocket manager(3'000'000);
  const ServiceNotifier notifier;
  EXPECT_EQ(notifier.watchdog_ns(), 3 * kOneSecond);
  notifier.ready();
  notifier.status("tracking");
  notifier.alive();
  notifier.stopping();
  EXPECT_EQ(manager.said(), (std::vector<std::string>{"READY=1", "STATUS=tracking", "WATCHDOG=1", "STOPPING=1"}));
}

TEST(ServiceNotifier, IsSilentWithoutAManager) {
  ::unsetenv("NOTIFY_SOCKET");
  const ServiceNotifier notifier;
  EXPECT_EQ(notifier.watchdog_ns(), 0);
  notifier.ready();
  notifier.status("tracking");
}

// Signs of life in ten seconds of 50 turns each.
int fed(const FrameWatchdog::Progress& each_turn, std::int64_t period_ns = 20'000'000) {
  FrameWatchdog watchdog(2 * kOneSecond, period_ns);
  FrameWatchdog::Progress progress = each_turn;
  progress.frames = progress.calls = 0;
  int times = watchdog.due(0, progress) ? 1 : 0;  // the start
  EXPECT_EQ(times, 1);
  times = 0;
  for (std::int64_t now = 20'000'000; now <= 10 * kOneSecond; now += 20'000'000) {
    progress.frames += each_turn.frames;
    progress.calls += each_turn.calls;
    times += watchdog.due(now, progress) ? 1 : 0;
  }
  return times;
}

TEST(FrameWatchdog, IsFedByFrames) {
  EXPECT_EQ(fed({1, 1, 0, false}), 20);
  EXPECT_EQ(fed({1, 1, 3, false}), 20) << "some are always under way";
  EXPECT_EQ(fed({0, 1, 0, false}), 0) << "a camera that answers nothing, or a loop that hangs";
  EXPECT_EQ(fed({0, 0, 0, true}), 0) << "away, and nobody calls it";
}

TEST(FrameWatchdog, LetsACameraComeBackAndARecordingTakeItsTime) {
  EXPECT_EQ(fed({0, 1, 0, true}), 20);
  EXPECT_EQ(fed({0, 1, 0, false}, 0), 20);
}

TEST(FrameWatchdog, LetsACameraWaitForItsTriggers) {
  EXPECT_EQ(fed({0, 1, 0, false}, 0), 20);
  EXPECT_EQ(fed({0, 1, 0, false}, 5 * kOneSecond), 20) << "slower than the watchdog's interval";
  EXPECT_EQ(fed({0, 1, 1, false}, 0), 0) << "a frame came, and does not get through";
  EXPECT_EQ(fed({0, 1, 1, true}), 0);
}

TEST(FrameWatchdog, IsNotFedWhenNobodyWatches) {
  FrameWatchdog watchdog(0, 20'000'000);
  EXPECT_FALSE(watchdog.due(0, {1, 1, 0, false}));
}

// A run in a process of its own. Gives its wait status.
template <class Run>
int in_a_process(Run run) {
  const pid_t child = ::fork();
  EXPECT_GE(child, 0);
  if (child == 0) {
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    run();
    ::_exit(0);
  }
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return status;
}

LastEnd open(const fakes::ScratchFolder& scratch) {
  auto opened = LastEnd::open(scratch.path() / "state");
  EXPECT_TRUE(opened.ok()) << opened.error().text();
  return *opened;
}

TEST(LastEnd, ACleanStopIsForgotten) {
  const fakes::ScratchFolder scratch;
  const LastEnd first = open(scratch);
  EXPECT_EQ(first.restarts(), 0u);
  EXPECT_EQ(first.text(), "");
  first.clear();
  EXPECT_EQ(open(scratch).restarts(), 0u);
}

TEST(LastEnd, TheReasonAndTheCountOutliveTheRun) {
  const fakes::ScratchFolder scratch;
  open(scratch).write("the camera is gone\n: \"video0\"" + std::string(200, 'x'));
  const LastEnd second = open(scratch);
  EXPECT_EQ(second.restarts(), 1u);
  EXPECT_EQ(second.text().size(), LastEnd::kMaxText);
  EXPECT_TRUE(second.text().starts_with("the camera is gone : \"video0\"x")) << second.text();
  EXPECT_EQ(open(scratch).text(), "ended without a word: killed, or the power went");
  EXPECT_EQ(open(scratch).restarts(), 3u);
}

TEST(LastEnd, AFatalSignalLeavesItsName) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    const fakes::ScratchFolder scratch;
    const int status = in_a_process([&] {
      for (const int other : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) ::signal(other, SIG_DFL);
      open(scratch).catch_fatal_signals();
      ::raise(signal);
    });
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal) << "the signal still ends the process";
    const LastEnd next = open(scratch);
    EXPECT_EQ(next.restarts(), 1u);
    EXPECT_TRUE(next.text().starts_with(std::string("SIG") + ::sigabbrev_np(signal) + ": ")) << next.text();
  }
}

TEST(LastEnd, TellsTheWatchdogFromABrokenAssumption) {
  const fakes::ScratchFolder scratch;
  const pid_t parent = ::getpid();
  std::array<int, 2> ready{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    open(scratch).catch_fatal_signals();
    (void)!::write(ready[1], "r", 1);
    while (::getppid() == parent) ::pause();
    ::_exit(0);
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  ::kill(child, SIGABRT);  // as systemd does
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_NE(open(scratch).text().find("the watchdog saw no frame"), std::string::npos);
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST(LastEnd, AKilledRunIsKnownFromItsSilence) {
  const fakes::ScratchFolder scratch;
  in_a_process([&] {
    open(scratch).catch_fatal_signals();
    ::kill(::getpid(), SIGKILL);
  });
  EXPECT_NE(open(scratch).text().find("killed"), std::string::npos);
}

TEST(LastEnd, ASpoiltFileStillMeansAnAbnormalEnd) {
  for (const char* text : {"", "x", "many\nreason\n", "4294967295\nreason\n", "\xFF\xFE\n\x01\n"}) {
    const fakes::ScratchFolder scratch;
    scratch.write("state/last_end", text);
    EXPECT_EQ(open(scratch).restarts(), 1u) << text;
  }
}

TEST(LastEnd, TakesTheManagersFirstFolder) {
  ::setenv("STATE_DIRECTORY", "/var/lib/srd:/var/lib/other", 1);
  EXPECT_EQ(LastEnd::service_folder(), "/var/lib/srd");
  ::unsetenv("STATE_DIRECTORY");
  EXPECT_EQ(LastEnd::service_folder(), "");
  const auto nowhere = LastEnd::open("");
  ASSERT_TRUE(nowhere.ok());
  nowhere->write("nothing is kept");
}

}  // namespace
}  // namespace srd::firmware
