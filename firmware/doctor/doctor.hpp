// SPDX-License-Identifier: Apache-2.0
// srd-node --doctor: looks at everything that a measurement needs, says what it found and what to do, and goes on to the
// end whatever fails, unless it is told to stop.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "drivers/strobe/gpiod_line.hpp"
#include "firmware/config/instrument.hpp"
#include "firmware/doctor/finding.hpp"
#include "firmware/realtime/realtime.hpp"
#include "firmware/strobe/strobe.hpp"

namespace srd::firmware {

struct DoctorOptions {
  std::filesystem::path root = "/";                     // where /sys and /dev are; another folder in tests
  std::chrono::milliseconds wake_ups{1000};             // how long the clock is watched
  std::chrono::milliseconds camera_time{3000};          // for the camera's frames
  std::chrono::milliseconds answer_time{2000};          // for the host's answer
  std::uint64_t write_bytes = std::uint64_t{32} << 20;  // to the disk
  const std::atomic<bool>* stop = nullptr;              // set: no more frames, no further part; null: never

  [[nodiscard]] bool stopping() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

// The strobe for a camera that has started: see config/strobe_factory.hpp.
using OpenLight = std::function<Outcome<std::unique_ptr<Strobe>>(const Camera&)>;

// The parts, in their order. Each adds at least one finding, unless it is stopped.
void check_camera(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis);
// The same with an instrument and a strobe of one's own.
void check_camera(const NodeConfig& config, Instrument& instrument, const OpenLight& open_light, const DoctorOptions& options,
                  Diagnosis& diagnosis);
// lines: that the configuration drives; each is opened, off, and given back.
void check_gpio(std::span<const LineAddress> lines, const DoctorOptions& options, Diagnosis& diagnosis);
void check_clock(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis);
void check_permissions(const NodeConfig& config, Diagnosis& diagnosis, const RealtimeCalls& calls = system_calls());
void check_network(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis);
void check_disk(const NodeConfig& config, const DoctorOptions& options, Diagnosis& diagnosis);
void check_board(const DoctorOptions& options, Diagnosis& diagnosis);

// All of them. config: as loaded, or why it could not be; null: none was named, and what needs one is passed over.
void examine(const Outcome<NodeConfig>* config, const DoctorOptions& options, Diagnosis& diagnosis);

}  // namespace srd::firmware
