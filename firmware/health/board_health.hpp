// SPDX-License-Identifier: Apache-2.0
// The board's temperature and whether it slows down, from files that Linux shows: /sys of any board, and the Raspberry Pi's
// own. Opened once; reading takes nothing from the heap. One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "drivers/support/unique_fd.hpp"
#include "proto/messages.hpp"

namespace srd::firmware {

struct HealthReading {
  float temperature_c = std::numeric_limits<float>::quiet_NaN();  // NaN: not known
  std::uint32_t throttled = 0;                                    // proto::Throttled bits
};

class BoardHealth {
 public:
  // root: "/", another folder in tests.
  explicit BoardHealth(const std::filesystem::path& root = "/");

  [[nodiscard]] HealthReading read() noexcept;

  // For a person: where the temperature comes from ("cpu-thermal"), empty when there is none.
  [[nodiscard]] const std::string& thermal_zone() const { return zone_; }
  // Whether anything says that the board slows down.
  [[nodiscard]] bool knows_throttling() const { return firmware_.valid() || !cooling_.empty() || !limits_.empty(); }

 private:
  struct Limit {
    UniqueFd allowed, possible;  // scaling_max_freq and cpuinfo_max_freq, kHz
  };
  std::string zone_;
  UniqueFd temperature_;           // thousandths of a degree C
  UniqueFd firmware_;              // of the Raspberry Pi: the bits, hexadecimal
  UniqueFd voltage_alarm_;         // 1: under-voltage (Raspberry Pi's hwmon)
  std::vector<UniqueFd> cooling_;  // of the processor: > 0 when it is slowed down
  std::vector<Limit> limits_;
  std::uint32_t ever_ = 0;  // since the node started, of what does not remember itself
};

}  // namespace srd::firmware
