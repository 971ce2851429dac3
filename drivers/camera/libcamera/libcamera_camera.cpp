// SPDX-License-Identifier: Apache-2.0
// A libcamera camera through the camera interface, and the list of those that are there.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "drivers/camera/frame_pool.hpp"
#include "drivers/camera/frame_sequence.hpp"
#include "drivers/camera/libcamera/dma_buf_access.hpp"
#include "drivers/camera/libcamera/libcamera_driver.hpp"
#include "drivers/camera/libcamera/libcamera_session.hpp"
#include "drivers/camera/libcamera/libcamera_version.hpp"
#include "drivers/camera/stamp_gate.hpp"
#include "drivers/support/system_clock.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

constexpr auto kTimeoutLeast = std::chrono::seconds(1);
constexpr auto kStallLeast = std::chrono::seconds(2);
constexpr auto kBetweenTries = std::chrono::milliseconds(500);

// libcamera says CLOCK_BOOTTIME; most pipelines hand on the kernel's CLOCK_MONOTONIC. They differ by the time asleep.
ClockId nearest_clock(std::int64_t stamp_ns) {
  const std::int64_t monotonic = clock_ns(CLOCK_MONOTONIC), boot = clock_ns(CLOCK_BOOTTIME);
  return std::abs(stamp_ns - monotonic) <= std::abs(stamp_ns - boot) ? ClockId::kMonotonic : ClockId::kBoottime;
}

class LibcameraCamera final : public Camera {
 public:
  explicit LibcameraCamera(const LibcameraOptions& options) : options_(options) {
    options_.buffers = std::clamp(options_.buffers, 3, FramePool::kMaxBuffers);
  }
  ~LibcameraCamera() override { stop(); }

  Outcome<void> start() override {
    stop();
    if (auto done = session_.start(options_); !done) return done.error();
    options_.id = session_.id();  // the same one after a reconnect
    buffers_ = session_.buffers();
    if (!session_.format().zero_copy()) {
      buffers_ = options_.buffers;
      own_.reserve(width(), height(), buffers_);
    }
    const double rate = options_.rate_hz.value_or(0);
    period_ = Nanoseconds(rate > 0 ? static_cast<std::int64_t>(1e9 / rate) : 0);
    sequence_ = FrameSequence(period_.count());
    gate_ = StampGate(period_.count());
    gate_.begin(clock_ns(CLOCK_MONOTONIC));
    timing_ = options_.timing;
    if (session_.exposure_us() > 0) timing_.exposure_ns = 1000 * session_.exposure_us();
    started_ = true;
    disconnected_ = reconnected_ = stopped_disconnected_ = false;
    clock_ = ClockId::kUnknown;
    saw_frame();
    return {};
  }

  Capture next(CameraFrame& frame, Nanoseconds timeout) noexcept override {
    if (!started_) return Capture::kEnd;
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    if (disconnected_)
      if (const Capture recovered = recover(deadline); recovered != Capture::kFrame) return recovered;
    std::uint32_t own_buffer = 0;
    const bool zero_copy = session_.format().zero_copy();
    if (!zero_copy) {
      const auto found = own_.acquire(deadline);
      if (!found) return Capture::kTimeout;
      own_buffer = *found;
    }
    const auto left = std::max(Nanoseconds(0), Nanoseconds(deadline - std::chrono::steady_clock::now()));
    Capture result = Capture::kTimeout;
    CompletedRequest request;
    const std::int64_t wait_from = clock_ns(CLOCK_MONOTONIC);
    const LibcameraSession::Ready ready = session_.wait(left);
    gate_.waited(wait_from, clock_ns(CLOCK_MONOTONIC));
    switch (ready) {
      case LibcameraSession::Ready::kGone: result = lose("the camera was removed"); break;
      case LibcameraSession::Ready::kTimeout: result = silent(); break;
      case LibcameraSession::Ready::kFrame:
        if (session_.take(request)) result = make_frame(request, own_buffer, frame);
        break;
    }
    if (!zero_copy && result != Capture::kFrame) own_.release(own_buffer);
    return result;
  }

  void give_back(const CameraFrame& frame) noexcept override {
    if (frame.image.pixels == nullptr) return;
    if (session_.format().zero_copy()) {
      end_cpu_read(session_.dma_buf(frame.buffer));
      session_.give_back(frame.buffer);
    } else {
      own_.release(frame.buffer);
    }
  }

  void stop() noexcept override {
    stopped_disconnected_ = started_ && disconnected_;
    started_ = false;
    session_.stop();
  }

  int width() const override { return options_.width; }
  int height() const override { return options_.height; }
  int buffer_count() const override { return buffers_; }
  bool live() const override { return true; }
  FrameTiming timing() const override { return timing_; }

  std::string summary() const override {
    if (!started_) return {};
    std::string text = "camera    libcamera " + std::to_string(LIBCAMERA_VERSION_MAJOR) + "." +
                       std::to_string(LIBCAMERA_VERSION_MINOR) + "." + std::to_string(LIBCAMERA_VERSION_PATCH) + ", " +
                       session_.id() + ", " + std::to_string(width()) + " x " + std::to_string(height()) + " " +
                       session_.format().format.toString();
    if (session_.sets_rate()) text += " at " + number_text(options_.rate_hz.value_or(0)) + " Hz";
    text += session_.format().zero_copy() ? ", read in place" : ", converted to grey";
    text +=
        ", " + std::to_string(buffers_) + " buffers\nstamps    of the " + std::string(to_string(options_.timing.mark)) + "\n";
    for (const std::string& note : session_.notes()) text += "note      " + note + "\n";
    return text;
  }
  std::vector<std::string> image_concerns() const override { return session_.concerns(); }
  std::string last_words() const override {
    return stopped_disconnected_ ? "camera    " + options_.id + " went away and did not come back: " + why_ + "\n"
                                 : std::string();
  }

 private:
  void saw_frame() noexcept {
    last_frame_ = std::chrono::steady_clock::now();
    stalled_ = false;
  }

  Capture make_frame(const CompletedRequest& request, std::uint32_t own_buffer, CameraFrame& frame) noexcept {
    saw_frame();
    if (reconnected_) {
      reconnected_ = false;
      count_one(faults_.reconnects);
    }
    const std::int64_t now_ns = clock_ns(CLOCK_MONOTONIC);
    if (request.stamp_ns != 0 && clock_ == ClockId::kUnknown) clock_ = nearest_clock(request.stamp_ns);
    frame = {};
    // As on the monotonic clock, which the gate keeps.
    const std::int64_t asleep = clock_ == ClockId::kBoottime ? clock_ns(CLOCK_BOOTTIME) - now_ns : 0;
    const bool by_arrival = !gate_.possible(request.stamp_ns - asleep, now_ns);
    gate_.gave(by_arrival ? now_ns : request.stamp_ns - asleep);
    if (by_arrival && request.stamp_ns != 0 && request.good) count_one(faults_.bad_stamps);
    frame.clock = by_arrival ? ClockId::kMonotonic : clock_;
    FrameTiming timing = timing_;
    if (by_arrival) timing.mark = StampMark::kFrameEnd;
    if (request.exposure_us > 0) timing.exposure_ns = 1000 * request.exposure_us;
    frame.sequence = request.numbered ? sequence_.next(request.sequence, now_ns) : sequence_.next_unnumbered(now_ns);
    frame.time_ns = timing.middle_ns(by_arrival ? now_ns : request.stamp_ns);
    frame.exposure_us = static_cast<std::uint32_t>(timing.exposure_ns / 1000);
    if (!request.good) {
      count_one(faults_.error_buffers);
      session_.give_back(request.buffer);
      return Capture::kBadFrame;
    }
    const LibcameraFormat& format = session_.format();
    const std::uint8_t* pixels = session_.pixels(request.buffer);
    if (format.zero_copy()) {
      begin_cpu_read(session_.dma_buf(request.buffer));
      frame.image = {pixels, width(), height(), session_.stride_bytes()};
      frame.buffer = request.buffer;
      return Capture::kFrame;
    }
    {
      const CpuRead reading(session_.dma_buf(request.buffer));
      convert_to_gray(format.layout, format.bits, pixels, session_.stride_bytes(), own_.pixels(own_buffer), own_.stride_bytes(),
                      width(), height());
    }
    session_.give_back(request.buffer);
    frame.image = own_.view(own_buffer);
    frame.buffer = own_buffer;
    return Capture::kFrame;
  }

  // No frame within the time given.
  Capture silent() noexcept {
    if (options_.trigger_input || session_.borrowed() >= session_.buffers()) return Capture::kTimeout;
    const auto silence = std::chrono::steady_clock::now() - last_frame_;
    if (!stalled_ && silence > std::max<Nanoseconds>(kTimeoutLeast, 4 * period_)) {
      stalled_ = true;
      count_one(faults_.timeouts);
    }
    if (silence > std::max<Nanoseconds>(kStallLeast, 20 * period_)) return lose("no frame came");
    return Capture::kTimeout;
  }

  Capture lose(const char* why) noexcept {
    if (!reconnected_) count_one(faults_.disconnects);
    reconnected_ = false;
    disconnected_ = true;
    why_ = why;
    sequence_.restart();
    return Capture::kDisconnected;
  }

  // One try at most. kFrame: streams again.
  Capture recover(std::chrono::steady_clock::time_point deadline) noexcept {
    if (session_.borrowed() > 0) {  // borrowed images lie in the mappings
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return Capture::kDisconnected;
    }
    session_.stop();
    if (next_try_ > deadline) {
      std::this_thread::sleep_until(deadline);
      return Capture::kDisconnected;
    }
    std::this_thread::sleep_until(next_try_);
    // Also after a try that seemed to work: a camera may start and fail at once.
    next_try_ = std::chrono::steady_clock::now() + kBetweenTries;
    if (auto done = session_.start(options_); !done) {
      why_ = done.error().what + (done.error().found.empty() ? "" : ", found " + done.error().found);
      std::this_thread::sleep_until(std::min(next_try_, deadline));
      return Capture::kDisconnected;
    }
    disconnected_ = false;
    reconnected_ = true;
    clock_ = ClockId::kUnknown;
    saw_frame();
    gate_.begin(clock_ns(CLOCK_MONOTONIC));
    return Capture::kFrame;
  }

  LibcameraOptions options_;
  LibcameraSession session_;
  FramePool own_;  // of converted images
  FrameSequence sequence_;
  StampGate gate_;
  Nanoseconds period_{0};
  FrameTiming timing_;
  int buffers_ = 0;
  bool started_ = false, disconnected_ = false, reconnected_ = false, stalled_ = false, stopped_disconnected_ = false;
  ClockId clock_ = ClockId::kUnknown;
  std::chrono::steady_clock::time_point last_frame_{}, next_try_{};
  std::string why_;
};

}  // namespace

bool libcamera_is_built() { return true; }

Outcome<std::unique_ptr<Camera>> make_libcamera_camera(const LibcameraOptions& options) {
  return std::unique_ptr<Camera>(std::make_unique<LibcameraCamera>(options));
}

std::string list_libcamera_cameras() {
  std::string text = "libcamera cameras:\n";
  int error = 0;
  const auto manager = camera_manager(error);
  if (!manager) return text + "  libcamera does not start: " + std::strerror(error) + "\n";
  const auto cameras = manager->cameras();
  if (cameras.empty()) return text + "  none\n";
  for (const auto& camera : cameras) {
    const auto model = camera->properties().get(libcamera::properties::Model);
    text += "  libcamera:" + camera->id() + (model ? "  " + std::string(*model) : std::string()) + "\n";
    const auto configuration = configuration_for(*camera, libcamera::StreamRole::Viewfinder);
    if (configuration && !configuration->empty())
      text += libcamera_offers(configuration->at(0).formats(), "    ") + "\n";
    else
      text += "    its configuration cannot be read\n";
  }
  return text;
}

}  // namespace srd
