// SPDX-License-Identifier: Apache-2.0
// Clock, permissions, GPIO and the board itself.
#include <fcntl.h>
#include <grp.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <thread>
#include <vector>

#include "drivers/support/formatted.hpp"
#include "drivers/support/system_clock.hpp"
#include "firmware/doctor/doctor.hpp"
#include "firmware/health/board_health.hpp"
#include "firmware/health/clock_health.hpp"

namespace srd::firmware {

namespace {

constexpr std::int64_t kWakeEvery_ns = 1'000'000;
constexpr double kMostLateness_us = 200;          // what a strobe pulse may be late by default
constexpr rlim_t kMinLocked = rlim_t{256} << 20;  // all that is reserved counts, used or not
constexpr float kHot_c = 80;

// How late a thread of this priority wakes, us, sorted. Sleeps to absolute times, as the strobe does.
std::vector<double> lateness_us(int priority, std::chrono::milliseconds time) {
  std::vector<double> late;
  std::thread([&] {
    if (priority > 0) (void)system_calls().set_priority(priority);
    const std::int64_t begin = clock_ns(CLOCK_MONOTONIC);
    for (std::int64_t at = begin + kWakeEvery_ns; at < begin + time / std::chrono::nanoseconds(1); at += kWakeEvery_ns) {
      sleep_until_ns(at);
      late.push_back(static_cast<double>(clock_ns(CLOCK_MONOTONIC) - at) / 1e3);
    }
  }).join();
  std::sort(late.begin(), late.end());
  return late;
}

bool in_group(const char* name) {
  const group* entry = ::getgrnam(name);
  if (entry == nullptr) return true;  // a system without it gives the rights another way
  std::vector<gid_t> groups(static_cast<std::size_t>(std::max(::getgroups(0, nullptr), 0)));
  groups.resize(static_cast<std::size_t>(std::max(::getgroups(static_cast<int>(groups.size()), groups.data()), 0)));
  return ::getegid() == entry->gr_gid || std::find(groups.begin(), groups.end(), entry->gr_gid) != groups.end();
}

}  // namespace

void check_gpio(std::span<const LineAddress> lines, const DoctorOptions& options, Diagnosis& diagnosis) {
  for (const LineAddress& line : lines) {
    if (const auto opened = open_gpiod_line(line, "srd-doctor"); !opened)
      diagnosis.fail("GPIO", opened.error());
    else
      diagnosis.ok("GPIO", line.text() + " is there and free");
  }
  if (!lines.empty()) return;
  std::string usable, refused;
  int error = 0;
  std::error_code ignored;
  for (std::filesystem::directory_iterator it(options.root / "dev", ignored), end; !ignored && it != end;
       it.increment(ignored)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with("gpiochip")) continue;
    const UniqueFd chip(::open(it->path().c_str(), O_RDWR | O_CLOEXEC));
    if (!chip.valid()) error = errno;
    (chip.valid() ? usable : refused) += " " + name;
  }
  if (!refused.empty())
    diagnosis.warn("GPIO", "cannot be opened:" + refused + " (" + std::strerror(error) + ")",
                   "group gpio for the node's user, and the udev rule of the package");
  if (!usable.empty()) diagnosis.ok("GPIO", "can be opened:" + usable);
  if (usable.empty() && refused.empty()) diagnosis.ok("GPIO", "no chip: this board cannot strobe");
}

void check_clock(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis) {
  const ClockHealth clock = read_clock_health();
  switch (clock.state) {
    case proto::ClockState::kSynchronised:
      diagnosis.ok("clock", formatted("follows a reference, %.3f ms to correct, error below %.1f ms",
                                      static_cast<double>(clock.offset_ns.value_or(0)) / 1e6,
                                      static_cast<double>(clock.uncertainty_ns) / 1e6));
      break;
    case proto::ClockState::kUnsynchronised:
      diagnosis.warn("clock", "does not follow a reference: times of nodes cannot be compared",
                     "chrony or systemd-timesyncd with a server that the node reaches; 'chronyc sources' tells");
      break;
    case proto::ClockState::kUnknown:
      diagnosis.warn("clock", "the kernel does not say whether it follows a reference", "a system with adjtimex");
  }
  timespec resolution{};
  ::clock_getres(CLOCK_MONOTONIC, &resolution);
  const auto late = lateness_us(config.realtime.strobe_priority, options.wake_ups);
  if (late.empty()) return;
  const auto at = [&](double share) { return late[static_cast<std::size_t>(share * static_cast<double>(late.size() - 1))]; };
  const std::string found =
      formatted("resolution %ld ns; late by %.0f us at the median, %.0f us at 99 %%, %.0f us at most, of %zu times",
                static_cast<long>(resolution.tv_nsec), at(0.5), at(0.99), late.back(), late.size());
  if (resolution.tv_sec > 0 || resolution.tv_nsec > 1000)
    diagnosis.warn("wake-ups", found, "a kernel with high-resolution timers (CONFIG_HIGH_RES_TIMERS)");
  else if (late.back() > kMostLateness_us)
    diagnosis.warn("wake-ups", found, "real-time priority (below), CPUs of their own ([realtime]), a PREEMPT_RT kernel");
  else
    diagnosis.ok("wake-ups", found);
}

void check_permissions(const NodeConfig& config, Diagnosis& diagnosis, const RealtimeCalls& calls) {
  const RealtimeSection& section = config.realtime;
  const int highest = std::max({section.capture_priority, section.strobe_priority, section.process_priority});
  int refused = 0;
  if (highest > 0) std::thread([&] { refused = calls.set_priority(highest); }).join();
  if (refused != 0)
    diagnosis.warn("priority", "SCHED_FIFO " + std::to_string(highest) + " is not permitted (" + std::strerror(refused) + ")",
                   "LimitRTPRIO=90 in the unit, 'rtprio 90' in /etc/security/limits.d, or CAP_SYS_NICE");
  else
    diagnosis.ok("priority", highest > 0 ? "SCHED_FIFO " + std::to_string(highest) + " is permitted" : "none is asked for");
  rlimit locked{};
  ::getrlimit(RLIMIT_MEMLOCK, &locked);
  if (!section.lock_memory)
    diagnosis.ok("memory", "is not to be locked");
  else if (calls.may_lock_everything())
    diagnosis.ok("memory", "may be locked without a limit");
  else if (locked.rlim_cur >= kMinLocked)
    diagnosis.ok("memory", formatted("up to %llu MiB may be locked", static_cast<unsigned long long>(locked.rlim_cur >> 20)));
  else
    diagnosis.warn("memory", formatted("only %llu KiB may be locked", static_cast<unsigned long long>(locked.rlim_cur >> 10)),
                   "LimitMEMLOCK=infinity in the unit, 'memlock unlimited' in /etc/security/limits.d, or CAP_IPC_LOCK");
  if (::geteuid() == 0) {
    diagnosis.ok("groups", "root needs none");
    return;
  }
  std::string missing;
  for (const char* name : {"video", "gpio"})
    if (!in_group(name)) missing += std::string(missing.empty() ? "" : ", ") + name;
  if (missing.empty())
    diagnosis.ok("groups", "video and gpio, as far as this system has them");
  else
    diagnosis.warn("groups", "not in " + missing, "SupplementaryGroups= in the unit, or 'adduser USER GROUP' and a new login");
}

void check_board(const DoctorOptions& options, Diagnosis& diagnosis) {
  BoardHealth health(options.root);
  const HealthReading reading = health.read();
  if (!std::isfinite(reading.temperature_c))
    diagnosis.ok("temperature", "this board does not tell");
  else if (reading.temperature_c >= kHot_c)
    diagnosis.warn("temperature",
                   formatted("%.0f C (%s)", static_cast<double>(reading.temperature_c), health.thermal_zone().c_str()),
                   "a heat sink or a fan, and shade");
  else
    diagnosis.ok("temperature",
                 formatted("%.0f C (%s)", static_cast<double>(reading.temperature_c), health.thermal_zone().c_str()));
  const std::uint32_t now = reading.throttled & proto::Throttled::kNow,
                      once = reading.throttled >> proto::Throttled::kEverShift;
  if (reading.throttled == 0) {
    diagnosis.ok("throttling", health.knows_throttling() ? "none" : "this board does not tell");
    return;
  }
  const bool voltage = ((now | once) & proto::Throttled::kUnderVoltage) != 0;
  diagnosis.warn(
      "throttling",
      (now != 0 ? std::string("now: ") : std::string("since the start: ")) + proto::throttled_text(now != 0 ? now : once),
      voltage ? "a stronger power supply and a shorter, thicker cable" : "a heat sink or a fan, and shade");
}

}  // namespace srd::firmware
