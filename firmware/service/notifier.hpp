// SPDX-License-Identifier: Apache-2.0
// What the node tells systemd: that it runs, how it is, that it is alive. Without systemd nothing happens. One thread.
#pragma once

#include <cstdint>
#include <string>

namespace srd::firmware {

class ServiceNotifier {
 public:
  ServiceNotifier();

  void ready() const;
  void stopping() const;
  // One line, shown by systemctl status.
  void status(const std::string& line) const;
  void alive() const;

  // Within what time alive() must be called again, ns; 0: nobody watches.
  [[nodiscard]] std::int64_t watchdog_ns() const { return watchdog_ns_; }

 private:
  std::int64_t watchdog_ns_ = 0;
};

}  // namespace srd::firmware
