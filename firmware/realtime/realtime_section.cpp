// SPDX-License-Identifier: Apache-2.0
#include "firmware/realtime/realtime_section.hpp"

#include <cmath>

namespace srd::firmware {

namespace {

constexpr double kMaxCpu = 1023;

void read_cpus(TomlTable& table, const char* key, std::vector<int>& out) {
  const auto numbers = table.numbers(key, 0, {0, kMaxCpu});
  if (!numbers) return;
  for (const double number : *numbers) {
    if (number != std::floor(number)) {
      table.complain(key, "whole numbers of CPUs, such as [2, 3]", std::to_string(number));
      return;
    }
    out.push_back(static_cast<int>(number));
  }
}

}  // namespace

RealtimeSection read_realtime(TomlTable root) {
  RealtimeSection section;
  section.wanted = root.has("realtime");
  TomlTable table = root.table("realtime");
  if (auto lock = table.boolean("lock_memory")) section.lock_memory = *lock;
  const auto priority = [&](const char* key, int& out) {
    if (auto given = table.integer(key, {0, 99})) out = static_cast<int>(*given);
  };
  priority("capture_priority", section.capture_priority);
  priority("strobe_priority", section.strobe_priority);
  priority("process_priority", section.process_priority);
  read_cpus(table, "capture_cpus", section.capture_cpus);
  read_cpus(table, "strobe_cpus", section.strobe_cpus);
  read_cpus(table, "process_cpus", section.process_cpus);
  return section;
}

}  // namespace srd::firmware
