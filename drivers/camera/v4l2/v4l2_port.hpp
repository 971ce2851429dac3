// SPDX-License-Identifier: Apache-2.0
// The system calls on one video device, and the clock: all that the V4L2 driver asks of the machine. Tests script it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "drivers/support/mapped_region.hpp"

namespace srd {

class V4l2Port {
 public:
  enum class Ready : std::uint8_t { kFrame, kTimeout, kError };

  virtual ~V4l2Port() = default;
  // 0 or errno. A device that is open is closed first.
  [[nodiscard]] virtual int open(const char* path) noexcept = 0;
  virtual void close() noexcept = 0;
  // ioctl: 0 or errno. From any thread while the device is open.
  [[nodiscard]] virtual int control(unsigned long request, void* argument) noexcept = 0;
  // Not valid, with errno, when it cannot be mapped.
  [[nodiscard]] virtual MappedRegion map(std::size_t length, std::int64_t offset) noexcept = 0;
  // Until a buffer can be taken.
  [[nodiscard]] virtual Ready wait(std::chrono::nanoseconds timeout) noexcept = 0;
  // CLOCK_MONOTONIC, as drivers stamp frames with, ns.
  [[nodiscard]] virtual std::int64_t now_ns() noexcept = 0;
  virtual void pause(std::chrono::nanoseconds time) noexcept = 0;
};

[[nodiscard]] std::unique_ptr<V4l2Port> system_v4l2_port();

}  // namespace srd
