// SPDX-License-Identifier: Apache-2.0
#include "firmware/service/notifier.hpp"

#include <systemd/sd-daemon.h>

namespace srd::firmware {

namespace {

// The result is ignored: without systemd there is no listener.
void notify(const std::string& state) { (void)::sd_notify(0, state.c_str()); }

}  // namespace

ServiceNotifier::ServiceNotifier() {
  std::uint64_t interval_us = 0;
  if (::sd_watchdog_enabled(0, &interval_us) > 0) watchdog_ns_ = static_cast<std::int64_t>(interval_us) * 1000;
}

void ServiceNotifier::ready() const { notify("READY=1"); }
void ServiceNotifier::stopping() const { notify("STOPPING=1"); }
void ServiceNotifier::status(const std::string& line) const { notify("STATUS=" + line); }
void ServiceNotifier::alive() const { notify("WATCHDOG=1"); }

}  // namespace srd::firmware
