// SPDX-License-Identifier: Apache-2.0
// One libcamera camera, configured and streaming: requests made once, mapped once, reused. Torn down as a whole.
#pragma once

#include <libcamera/libcamera.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/camera/frame_pool.hpp"
#include "drivers/camera/libcamera/libcamera_driver.hpp"
#include "drivers/camera/libcamera/libcamera_formats.hpp"
#include "drivers/support/mapped_region.hpp"
#include "drivers/support/unique_fd.hpp"
#include "dsp/core/spsc_ring.hpp"

namespace srd {

// A process has one camera manager at most; this one lives as long as somebody holds it. Null: it does not start, and error
// is an errno.
// What it takes from the environment: libcamera_environment.hpp, for the first one.
[[nodiscard]] std::shared_ptr<libcamera::CameraManager> camera_manager(int& error, bool trigger_input = false);

// What libcamera's thread hands over.
struct CompletedRequest {
  std::uint32_t buffer = 0;
  bool numbered = false;  // sequence is this frame's: a cancelled request has the last frame's of its buffer
  std::uint32_t sequence = 0;
  std::int64_t stamp_ns = 0;     // 0: none
  std::int64_t exposure_us = 0;  // 0: not reported
  bool good = false;
};

// start, stop, wait and take from one thread, give_back from any.
class LibcameraSession {
 public:
  enum class Ready : std::uint8_t { kFrame, kTimeout, kGone };

  LibcameraSession() : completed_(kRingSlots) {}
  ~LibcameraSession() { stop(); }
  LibcameraSession(const LibcameraSession&) = delete;
  LibcameraSession& operator=(const LibcameraSession&) = delete;

  // kDevice when the camera is not there or cannot do what is asked; nothing is held then.
  [[nodiscard]] Outcome<void> start(const LibcameraOptions& options);
  // Only when borrowed() is 0.
  void stop() noexcept;
  [[nodiscard]] Ready wait(std::chrono::nanoseconds timeout) noexcept;
  // False: nothing there. The buffer is the caller's until give_back.
  [[nodiscard]] bool take(CompletedRequest& request) noexcept;
  void give_back(std::uint32_t buffer) noexcept;
  [[nodiscard]] int borrowed() const noexcept { return borrowed_.load(std::memory_order_acquire); }

  [[nodiscard]] const std::uint8_t* pixels(std::uint32_t buffer) const noexcept {
    return mapped_[buffer].region.data() + mapped_[buffer].offset;
  }
  // -1: no such buffer (any more).
  [[nodiscard]] int dma_buf(std::uint32_t buffer) const noexcept { return buffer < mapped_.size() ? mapped_[buffer].fd : -1; }
  [[nodiscard]] int buffers() const noexcept { return static_cast<int>(requests_.size()); }
  [[nodiscard]] int stride_bytes() const noexcept { return stride_; }
  [[nodiscard]] const LibcameraFormat& format() const noexcept { return format_; }
  [[nodiscard]] const std::string& id() const noexcept { return id_; }
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
  [[nodiscard]] const std::vector<std::string>& concerns() const { return concerns_; }  // Camera::image_concerns
  [[nodiscard]] bool sets_rate() const noexcept { return sets_rate_; }
  // That the camera was set to; 0: it was not.
  [[nodiscard]] std::int64_t exposure_us() const noexcept { return exposure_us_; }

 private:
  static constexpr std::size_t kRingSlots = 64;  // more than there are requests
  struct Mapped {
    MappedRegion region;
    std::size_t offset = 0;
    int fd = -1;  // libcamera's
  };
  Outcome<void> set_up(const LibcameraOptions& options);
  Outcome<void> configure(const LibcameraOptions& options);
  Outcome<void> map_buffers(const LibcameraOptions& options);
  Outcome<libcamera::ControlList> choose_controls(const LibcameraOptions& options);
  void abandon() noexcept;
  // On libcamera's thread.
  void completed(libcamera::Request* request);
  void disconnected();
  void wake() noexcept;

  std::shared_ptr<libcamera::CameraManager> manager_;
  std::shared_ptr<libcamera::Camera> camera_;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  libcamera::Stream* stream_ = nullptr;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;
  std::vector<Mapped> mapped_;
  SpscRing<CompletedRequest> completed_;
  UniqueFd wakeup_;
  std::mutex mutex_;  // of queueing against stopping
  std::atomic<bool> streaming_{false}, gone_{false};
  std::atomic<int> borrowed_{0};
  bool acquired_ = false, sets_rate_ = false;
  int stride_ = 0;
  std::int64_t exposure_us_ = 0;
  LibcameraFormat format_{};
  std::string id_;
  std::vector<std::string> notes_;
  std::vector<std::string> concerns_;
};

// "R8 640x480, 1280x720" a line a format that the driver takes, the others in one more.
[[nodiscard]] std::string libcamera_offers(const libcamera::StreamFormats& formats, const std::string& margin);

}  // namespace srd
