// SPDX-License-Identifier: Apache-2.0
// Image buffers that a camera hands out and gets back. Reserved once; acquire and release do not allocate.
#pragma once

#include <array>
#include <cassert>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "dsp/core/image_view.hpp"

namespace srd {

class FramePool {
 public:
  static constexpr int kMaxBuffers = 32;
  static constexpr int kAlignment = 64;  // bytes, of each row

  // Not while a buffer is out. width, height > 0 (px); 1 <= buffers <= kMaxBuffers.
  void reserve(int width, int height, int buffers) {
    assert(width > 0 && height > 0 && buffers >= 1 && buffers <= kMaxBuffers);
    width_ = width;
    height_ = height;
    stride_ = (width + kAlignment - 1) / kAlignment * kAlignment;
    buffers_ = buffers;
    const std::size_t bytes = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height);
    memory_.assign(bytes * static_cast<std::size_t>(buffers) + kAlignment, 0);
    const auto address = reinterpret_cast<std::uintptr_t>(memory_.data());
    first_ = memory_.data() + (kAlignment - address % kAlignment) % kAlignment;
    out_.fill(false);
  }

  // A free buffer; nothing when none is given back before the deadline.
  [[nodiscard]] std::optional<std::uint32_t> acquire(std::chrono::steady_clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    std::uint32_t found = 0;
    const auto free = [&] {
      for (found = 0; found < static_cast<std::uint32_t>(buffers_); ++found)
        if (!out_[found]) return true;
      return false;
    };
    if (!free() && !returned_.wait_until(lock, deadline, free)) return std::nullopt;
    out_[found] = true;
    return found;
  }

  // From any thread. A buffer that is not out is left as it is.
  void release(std::uint32_t buffer) {
    {
      const std::lock_guard lock(mutex_);
      if (buffer >= static_cast<std::uint32_t>(buffers_)) return;
      out_[buffer] = false;
    }
    returned_.notify_one();
  }

  [[nodiscard]] std::uint8_t* pixels(std::uint32_t buffer) {
    return first_ + static_cast<std::size_t>(buffer) * static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height_);
  }
  [[nodiscard]] GrayView view(std::uint32_t buffer) { return {pixels(buffer), width_, height_, stride_}; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int stride_bytes() const { return stride_; }
  [[nodiscard]] int buffers() const { return buffers_; }

 private:
  std::mutex mutex_;
  std::condition_variable returned_;
  std::vector<std::uint8_t> memory_;
  std::uint8_t* first_ = nullptr;
  std::array<bool, kMaxBuffers> out_{};
  int width_ = 0, height_ = 0, stride_ = 0, buffers_ = 0;
};

// Waits until a frame of a recording is due at its camera's rate, counted from the first one.
class FramePacer {
 public:
  void start() { running_ = false; }
  // False: not due within the timeout, which has passed.
  [[nodiscard]] bool wait(std::int64_t time_ns, std::chrono::nanoseconds timeout);

 private:
  bool running_ = false;
  std::chrono::steady_clock::time_point origin_;
  std::int64_t first_ns_ = 0;
};

}  // namespace srd
