// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/frame_recorder.hpp"

#include <chrono>
#include <cstdint>
#include <cstring>
#include <new>

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "firmware/service/stop_signals.hpp"

namespace srd::firmware {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kTurn = std::chrono::milliseconds(2);
constexpr auto kWaitForRoom = std::chrono::milliseconds(1);

std::filesystem::path unused(const std::filesystem::path& wanted) {
  std::error_code error;
  std::filesystem::path folder = wanted;
  for (int n = 2; std::filesystem::exists(folder / kFramesName, error); ++n) folder = wanted.string() + "-" + std::to_string(n);
  return folder;
}

// Where the folder lies, or will lie.
std::uint64_t free_mib_at(std::filesystem::path folder) {
  std::error_code error;
  folder = std::filesystem::absolute(folder, error);
  while (!std::filesystem::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  return error ? 0 : space.available >> 20;
}

Outcome<void> write_rig(const std::filesystem::path& folder, const RecordedRig& rig) {
  if (auto done = write_calibration(folder / kCalibrationName, rig.calibration); !done) return done;
  if (auto done = write_pose(folder / kPoseName, rig.pose, rig.pose_errors); !done) return done;
  if (auto done = write_recorded_optics(folder, rig.optics); !done) return done;
  return write_points(folder / kPointsName, rig.points);
}

}  // namespace

Outcome<std::unique_ptr<FrameRecorder>> FrameRecorder::start(const RecordingSection& section, const RecordedRig& rig, int width,
                                                             int height) {
  if (const std::uint64_t free_mib = free_mib_at(section.folder); free_mib < section.min_free_mib)
    return Problem{Exit::kInput,
                   "too little room for a recording",
                   section.folder.string(),
                   "at least " + std::to_string(section.min_free_mib) + " MiB free (record.min_free_mib)",
                   std::to_string(free_mib) + " MiB",
                   "make room, or name a folder on another disk"};
  const std::uint64_t queue_bytes =
      std::uint64_t{section.queue_frames} * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  std::unique_ptr<std::uint8_t[]> pixels;
  if (queue_bytes <= SIZE_MAX / 2)
    pixels.reset(new (std::nothrow) std::uint8_t[static_cast<std::size_t>(queue_bytes)]());  // touched: no page comes late
  if (!pixels)
    return Problem{Exit::kUsage,
                   "too little memory for the queue of a recording",
                   "record.queue_frames",
                   "images of " + std::to_string(width) + " x " + std::to_string(height) + " that fit the memory",
                   std::to_string(section.queue_frames) + ", " + std::to_string(queue_bytes >> 20) + " MiB",
                   "fewer"};
  const bool count = section.numbered_folders && !section.force;
  auto recording = DurableRecording::create(count ? unused(section.folder) : section.folder, section.force);
  if (!recording) return recording.error();
  if (auto written = write_rig(recording->folder(), rig); !written) return written.error();
  std::unique_ptr<FrameRecorder> made(new FrameRecorder(std::move(*recording), section, width, height, std::move(pixels)));
  const StopSignalsBlocked blocked;
  made->thread_ = std::thread([recorder = made.get()] { recorder->run(); });
  return made;
}

FrameRecorder::FrameRecorder(DurableRecording recording, const RecordingSection& section, int width, int height,
                             std::unique_ptr<std::uint8_t[]> pixels)
    : recording_(std::move(recording)),
      section_(section),
      width_(width),
      height_(height),
      image_bytes_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      pixels_(std::move(pixels)),
      queue_(section.queue_frames) {}

FrameRecorder::~FrameRecorder() { finish(); }

void FrameRecorder::take(const CameraFrame& frame, bool may_wait) noexcept {
  const GrayView& image = frame.image;
  const bool fits = image.width == width_ && image.height == height_;
  if (stopped() || !fits || (any_ && (frame.sequence <= last_sequence_ || frame.time_ns < last_time_ns_))) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  Queued* place = queue_.back();
  while (place == nullptr && may_wait && !stopped()) {
    std::this_thread::sleep_for(kWaitForRoom);
    place = queue_.back();
  }
  if (place == nullptr) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  any_ = true;
  last_sequence_ = frame.sequence;
  last_time_ns_ = frame.time_ns;
  // A place that is free means that the buffer of a whole round ago is written.
  *place = {frame.sequence, frame.time_ns, frame.exposure_us, frame.strobe, next_++ % section_.queue_frames};
  std::uint8_t* to = pixels(place->buffer);
  for (int v = 0; v < height_; ++v, to += width_) std::memcpy(to, image.row(v), static_cast<std::size_t>(width_));
  queue_.push();
}

void FrameRecorder::run() {
  const auto interval = std::chrono::milliseconds(section_.sync_ms);
  auto next_sync = Clock::now() + interval;
  for (;;) {
    const bool finishing = finishing_.load(std::memory_order_acquire);
    if (const Queued* queued = queue_.front(); queued != nullptr) {
      write(*queued);
      queue_.pop();
    } else if (finishing) {
      break;
    } else {
      std::this_thread::sleep_for(kTurn);
    }
    if (Clock::now() < next_sync) continue;
    sync();
    next_sync = Clock::now() + interval;
  }
  sync();
  dropped_.fetch_add(recording_.unlisted(), std::memory_order_relaxed);
}

void FrameRecorder::write(const Queued& queued) {
  if (!stopped() && recording_.free_bytes() >> 20 < section_.min_free_mib) stop(kTooLittleRoom);
  if (stopped()) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  const RecordedFrame frame{{}, queued.sequence, queued.time_ns, queued.exposure_us, queued.strobe};
  if (const int failure = recording_.add({pixels(queued.buffer), image_bytes_}, width_, height_, frame); failure != 0) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    stop(failure);
  }
}

void FrameRecorder::sync() {
  if (const int failure = recording_.sync(); failure != 0) stop(failure);
  recorded_.store(recording_.listed(), std::memory_order_relaxed);
}

void FrameRecorder::stop(int reason) {
  int going_on = kRecording;
  stop_reason_.compare_exchange_strong(going_on, reason, std::memory_order_acq_rel);
}

void FrameRecorder::finish() {
  finishing_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

std::string FrameRecorder::problem() const {
  const int reason = stop_reason_.load(std::memory_order_acquire);
  if (reason == kRecording) return {};
  if (reason == kTooLittleRoom) return "less than " + std::to_string(section_.min_free_mib) + " MiB free (record.min_free_mib)";
  return std::strerror(reason);
}

}  // namespace srd::firmware
