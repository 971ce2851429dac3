// SPDX-License-Identifier: Apache-2.0
// A GPIO chip of the kernel's simulator (gpio-sim, through configfs) with one named line, read back from outside.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "drivers/support/unique_fd.hpp"

namespace srd {

class SimulatedChip {
 public:
  static constexpr unsigned kLines = 8, kLine = 3;
  static constexpr const char* kLabel = "srd-test-chip";

  // Why there can be none here; empty: there can.
  [[nodiscard]] static std::string missing() {
    std::error_code error;
    if (std::filesystem::is_directory(kConfig, error) && ::access(kConfig, W_OK) == 0) return {};
    return std::string("no ") + kConfig + ": on the emulated board as root, after modprobe gpio-sim";
  }

  explicit SimulatedChip(const std::string& line_name) : device_(std::string(kConfig) + "/srd-" + std::to_string(::getpid())) {
    std::filesystem::create_directories(device_ + "/bank/line" + std::to_string(kLine));
    write(device_ + "/bank/num_lines", std::to_string(kLines));
    write(device_ + "/bank/label", kLabel);
    write(device_ + "/bank/line" + std::to_string(kLine) + "/name", line_name);
    write(device_ + "/live", "1");
    name_ = read(device_ + "/bank/chip_name");
    folder_ = "/sys/devices/platform/" + read(device_ + "/dev_name") + "/" + name_ + "/sim_gpio" + std::to_string(kLine);
    value_.reset(::open((folder_ + "/value").c_str(), O_RDONLY | O_CLOEXEC));
  }
  ~SimulatedChip() {
    write(device_ + "/live", "0");
    for (const char* folder : {"/bank/line3", "/bank", ""}) ::rmdir((device_ + folder).c_str());
  }
  SimulatedChip(const SimulatedChip&) = delete;
  SimulatedChip& operator=(const SimulatedChip&) = delete;

  [[nodiscard]] std::string path() const { return "/dev/" + name_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  // The line's physical level, as something wired to it would see. -1: not readable.
  [[nodiscard]] int level() const {
    char digit = 0;
    return ::pread(value_.get(), &digit, 1, 0) == 1 ? digit - '0' : -1;
  }
  void pull(bool up) { write(folder_ + "/pull", up ? "pull-up" : "pull-down"); }

 private:
  static constexpr const char* kConfig = "/sys/kernel/config/gpio-sim";
  static void write(const std::string& file, const std::string& text) { std::ofstream(file) << text << std::flush; }
  static std::string read(const std::string& file) {
    std::string text;
    std::ifstream(file) >> text;
    return text;
  }

  std::string device_, name_, folder_;
  UniqueFd value_;
};

}  // namespace srd
