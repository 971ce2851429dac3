// SPDX-License-Identifier: Apache-2.0
#include "firmware/health/board_health.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <optional>
#include <string_view>

namespace srd::firmware {

namespace {

namespace fs = std::filesystem;
using proto::Throttled;

// A number at a file's start, after "0x" in hexadecimal.
std::optional<std::int64_t> number_in(const UniqueFd& file, int base = 10) noexcept {
  std::array<char, 32> text;
  if (!file.valid()) return std::nullopt;
  const ssize_t size = ::pread(file.get(), text.data(), text.size(), 0);
  if (size <= 0) return std::nullopt;
  const char* begin = text.data();
  const char* const end = begin + size;
  if (base == 16 && size > 2 && begin[0] == '0' && begin[1] == 'x') begin += 2;
  std::int64_t value = 0;
  if (std::from_chars(begin, end, value, base).ec != std::errc{}) return std::nullopt;
  return value;
}

UniqueFd open_file(const fs::path& path) { return UniqueFd(::open(path.c_str(), O_RDONLY | O_CLOEXEC)); }

std::string first_line(const fs::path& path) {
  std::ifstream stream(path);
  std::string line;
  std::getline(stream, line);
  return line;
}

std::vector<fs::path> listed(const fs::path& folder, std::string_view prefix, std::string_view suffix = {}) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (const std::string name = it->path().filename().string(); name.starts_with(prefix) && name.ends_with(suffix))
      found.push_back(it->path());
  std::sort(found.begin(), found.end());
  return found;
}

// The bits of the Raspberry Pi's firmware. Its device is named after the bus: soc:firmware, soc@107c000000:firmware.
UniqueFd open_firmware(const fs::path& root) {
  for (const fs::path& bus : listed(root / "sys/devices/platform", "soc"))
    for (const fs::path& device : listed(bus, "soc", ":firmware"))
      if (UniqueFd file = open_file(device / "get_throttled"); file.valid()) return file;
  return {};
}

// 0: the processor's own zone; larger: worse.
int rank_of(const std::string& type) {
  static constexpr std::array kBest{"cpu-thermal", "cpu_thermal", "x86_pkg_temp", "soc-thermal", "soc_thermal"};
  for (std::size_t i = 0; i < kBest.size(); ++i)
    if (type == kBest[i]) return 0;
  for (const char* part : {"cpu", "soc", "package"})
    if (type.find(part) != std::string::npos) return 1;
  return 2;
}

}  // namespace

BoardHealth::BoardHealth(const fs::path& root) {
  int best = 3;
  for (const fs::path& zone : listed(root / "sys/class/thermal", "thermal_zone")) {
    const std::string type = first_line(zone / "type");
    UniqueFd file = open_file(zone / "temp");
    if (rank_of(type) >= best || !number_in(file)) continue;  // zones that cannot be read are common
    best = rank_of(type);
    zone_ = type;
    temperature_ = std::move(file);
  }
  firmware_ = open_firmware(root);
  for (const fs::path& monitor : listed(root / "sys/class/hwmon", "hwmon"))
    if (first_line(monitor / "name") == "rpi_volt") voltage_alarm_ = open_file(monitor / "in0_lcrit_alarm");
  for (const fs::path& device : listed(root / "sys/class/thermal", "cooling_device")) {
    const std::string type = first_line(device / "type");
    if (type == "Processor" || type.find("cpufreq") != std::string::npos) cooling_.push_back(open_file(device / "cur_state"));
  }
  for (const fs::path& policy : listed(root / "sys/devices/system/cpu/cpufreq", "policy")) {
    Limit limit{open_file(policy / "scaling_max_freq"), open_file(policy / "cpuinfo_max_freq")};
    if (!number_in(limit.allowed) || !number_in(limit.possible)) continue;
    // A person may have set it so: what counts is a limit that comes while the node runs.
    if (*number_in(limit.allowed) >= *number_in(limit.possible)) limits_.push_back(std::move(limit));
  }
}

HealthReading BoardHealth::read() noexcept {
  HealthReading reading;
  if (const auto thousandths = number_in(temperature_)) reading.temperature_c = static_cast<float>(*thousandths) / 1000;
  std::uint32_t now = 0;
  if (number_in(voltage_alarm_).value_or(0) > 0) now |= Throttled::kUnderVoltage;
  for (const UniqueFd& device : cooling_)
    if (number_in(device).value_or(0) > 0) now |= Throttled::kThrottled;
  for (const Limit& limit : limits_)
    if (number_in(limit.allowed).value_or(0) < number_in(limit.possible).value_or(0)) now |= Throttled::kCapped;
  ever_ |= now << Throttled::kEverShift;
  reading.throttled = now | ever_;
  if (const auto bits = number_in(firmware_, 16)) reading.throttled |= static_cast<std::uint32_t>(*bits) & Throttled::kAll;
  return reading;
}

}  // namespace srd::firmware
