// SPDX-License-Identifier: Apache-2.0
// [realtime]: how the node's threads are kept from waiting for the kernel.
#pragma once

#include <vector>

#include "drivers/support/toml_reader.hpp"

namespace srd::firmware {

struct RealtimeSection {
  bool wanted = false;      // the file has the table: also for cameras that are not live
  bool lock_memory = true;  // nothing of the process is paged out or comes late
  // SCHED_FIFO, 1 to 99; 0: as an ordinary thread.
  int capture_priority = 60, strobe_priority = 80, process_priority = 50;
  std::vector<int> capture_cpus, strobe_cpus, process_cpus;  // numbers; empty: any
};

[[nodiscard]] RealtimeSection read_realtime(TomlTable root);

}  // namespace srd::firmware
