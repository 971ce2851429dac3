// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/libcamera/libcamera_session.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>

#include "drivers/camera/libcamera/libcamera_choice.hpp"
#include "drivers/camera/libcamera/libcamera_environment.hpp"
#include "drivers/camera/libcamera/libcamera_image.hpp"
#include "drivers/camera/libcamera/libcamera_version.hpp"
#include "drivers/support/system_clock.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

namespace controls = libcamera::controls;

std::string size_text(const libcamera::Size& size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

std::string where_of(const LibcameraOptions& options) { return options.id.empty() ? "libcamera" : "libcamera:" + options.id; }

Problem trouble(const LibcameraOptions& options, std::string what, int error) {
  Problem problem{Exit::kDevice, std::move(what), where_of(options), "", std::strerror(error), ""};
  if (error == EBUSY) problem.advice = "end the program that uses the camera";
  if (error == EACCES || error == EPERM) problem.advice = "add the user to the group 'video' and log in again";
  return problem;
}

template <class T>
bool has(const libcamera::ControlInfoMap& known, const libcamera::Control<T>& control) {
  return known.count(&control) != 0;
}

// The value inside what the camera takes; a note when it is another one.
template <class T>
T inside(const libcamera::ControlInfoMap& known, const libcamera::Control<T>& control, T wanted, const char* name,
         const char* unit, std::vector<std::string>& notes) {
  const libcamera::ControlInfo& info = known.at(&control);
  if (info.min().isNone() || info.max().isNone()) return wanted;
  const T low = info.min().template get<T>(), high = info.max().template get<T>();
  if (!(low < high)) return wanted;
  const T value = std::clamp(wanted, low, high);
  if (value < wanted || value > wanted)
    notes.push_back(std::string(name) + " " + number_text(static_cast<double>(value)) + unit + " instead of " +
                    number_text(static_cast<double>(wanted)) + unit + ": the camera takes " +
                    number_text(static_cast<double>(low)) + " to " + number_text(static_cast<double>(high)) + unit);
  return value;
}

}  // namespace

std::shared_ptr<libcamera::CameraManager> camera_manager(int& error, bool trigger_input) {
  static std::mutex mutex;
  static std::weak_ptr<libcamera::CameraManager> shared;
  const std::lock_guard lock(mutex);
  if (auto running = shared.lock()) return running;
  prepare_libcamera(trigger_input);
  auto made = std::shared_ptr<libcamera::CameraManager>(new libcamera::CameraManager(), [](libcamera::CameraManager* manager) {
    manager->stop();
    delete manager;
  });
  if (error = -made->start(); error != 0) return nullptr;
  shared = made;
  return made;
}

std::string libcamera_offers(const libcamera::StreamFormats& formats, const std::string& margin) {
  std::string text, others;
  for (const libcamera::PixelFormat& format : formats.pixelformats()) {
    const bool usable = std::any_of(kLibcameraFormats.begin(), kLibcameraFormats.end(),
                                    [&](const LibcameraFormat& known) { return known.format == format; });
    if (!usable) {
      others += (others.empty() ? "" : ", ") + format.toString();
      continue;
    }
    std::string line = margin + format.toString();
    const std::vector<libcamera::Size> sizes = formats.sizes(format);
    const libcamera::SizeRange range = formats.range(format);
    if (range.min != range.max && range.hStep != 0)
      line += " " + size_text(range.min) + " to " + size_text(range.max);
    else
      for (std::size_t i = 0; i < sizes.size() && i < 12; ++i) line += (i == 0 ? " " : ", ") + size_text(sizes[i]);
    text += (text.empty() ? "" : "\n") + line;
  }
  if (!others.empty()) text += (text.empty() ? "" : "\n") + margin + "not usable: " + others;
  return text.empty() ? margin + "nothing" : text;
}

Outcome<void> LibcameraSession::start(const LibcameraOptions& options) {
  auto done = set_up(options);
  if (!done) stop();
  return done;
}

Outcome<void> LibcameraSession::set_up(const LibcameraOptions& options) {
  notes_.clear();
  gone_ = false;
  while (completed_.front() != nullptr) completed_.pop();
  if (!wakeup_.valid()) wakeup_.reset(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!wakeup_.valid()) return trouble(options, "libcamera's frames cannot be waited for", errno);
  int failure = 0;
  manager_ = camera_manager(failure, options.trigger_input);
  if (!manager_) return trouble(options, "libcamera does not start", failure);
  const auto cameras = manager_->cameras();
  if (options.id.empty() ? cameras.empty() : manager_->get(options.id) == nullptr) {
    std::string found;
    for (const auto& camera : cameras) found += (found.empty() ? "" : ", ") + camera->id();
    return Problem{Exit::kDevice,
                   "no such camera",
                   where_of(options),
                   "a camera that libcamera knows",
                   found.empty() ? "no cameras" : found,
                   "check the cable; srd-node --list-cameras shows what is there"};
  }
  camera_ = options.id.empty() ? cameras.front() : manager_->get(options.id);
  id_ = camera_->id();
  if (const int error = camera_->acquire(); error != 0) return trouble(options, "the camera cannot be had", -error);
  acquired_ = true;
  if (auto done = configure(options); !done) return done.error();
  if (auto done = map_buffers(options); !done) return done.error();
  auto set = choose_controls(options);
  if (!set) return set.error();
  camera_->requestCompleted.connect(this, &LibcameraSession::completed);
  camera_->disconnected.connect(this, &LibcameraSession::disconnected);
  if (const int error = camera_->start(&*set); error != 0) return trouble(options, "the camera does not start", -error);
  streaming_ = true;
  for (const auto& request : requests_)
    if (const int error = camera_->queueRequest(request.get()); error != 0)
      return trouble(options, "the camera takes no request", -error);
  return {};
}

Outcome<void> LibcameraSession::configure(const LibcameraOptions& options) {
  using libcamera::StreamRole;
  std::string offers;
  bool size_refused = false;
  const auto formats_of = [&](StreamRole role) {
    const auto configuration = configuration_for(*camera_, role);
    if (!configuration || configuration->empty()) return std::vector<libcamera::PixelFormat>();
    const libcamera::StreamFormats formats = configuration->at(0).formats();
    offers += (offers.empty() ? "" : "\n") + libcamera_offers(formats, "    ");
    return formats.pixelformats();
  };
  const auto processed = formats_of(StreamRole::Viewfinder), raw = formats_of(StreamRole::Raw);
  for (const StreamTry& wanted : streams_to_try(raw, processed)) {
    configuration_ = configuration_for(*camera_, wanted.role);
    if (!configuration_ || configuration_->empty()) continue;
    libcamera::StreamConfiguration& stream = configuration_->at(0);
    stream.pixelFormat = wanted.format.format;
    stream.size = {static_cast<unsigned>(options.width), static_cast<unsigned>(options.height)};
    stream.bufferCount = static_cast<unsigned>(options.buffers);
    if (configuration_->validate() == libcamera::CameraConfiguration::Invalid) continue;
    if (stream.pixelFormat != wanted.format.format) continue;
    if (stream.size.width != static_cast<unsigned>(options.width) ||
        stream.size.height != static_cast<unsigned>(options.height)) {
      size_refused = true;
      continue;
    }
    if (const int error = camera_->configure(configuration_.get()); error != 0)
      return trouble(options, "the camera cannot be configured", -error);
    format_ = wanted.format;
    stream_ = stream.stream();
    stride_ = static_cast<int>(stream.stride);
    if (const std::string why = why_not_raw(raw, wanted); !why.empty()) notes_.push_back(why);
    return {};
  }
  return Problem{Exit::kDevice,
                 size_refused ? "the camera does not offer this size" : "the camera has no usable pixel format",
                 where_of(options),
                 std::to_string(options.width) + "x" + std::to_string(options.height) +
                     " in R8, YUV420, NV12, R10, R12, R16, YUYV or RGB888",
                 "the camera offers\n" + offers,
                 "calibrate the camera in a size that it offers"};
}

Outcome<void> LibcameraSession::map_buffers(const LibcameraOptions& options) {
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  if (const int count = allocator_->allocate(stream_); count < 2)
    return trouble(options, "the camera's buffers cannot be had", count < 0 ? -count : ENOMEM);
  const std::int64_t row = row_bytes(format_.layout, options.width);
  stride_ = std::max(stride_, static_cast<int>(row));
  const std::int64_t image = static_cast<std::int64_t>(stride_) * (options.height - 1) + row;
  for (const auto& buffer : allocator_->buffers(stream_)) {
    if (mapped_.size() == FramePool::kMaxBuffers) break;
    const libcamera::FrameBuffer::Plane& plane = buffer->planes().front();
    Mapped mapped;
    mapped.fd = plane.fd.get();
    const std::size_t offset = plane.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
    if (static_cast<std::int64_t>(plane.length) < image)
      return trouble(options, "the camera's buffers are smaller than its images", EINVAL);
    // From the buffer's beginning: a plane need not begin at a page.
    mapped.region = MappedRegion::of_file(mapped.fd, offset + plane.length, 0, PROT_READ);
    mapped.offset = offset;
    if (!mapped.region.valid()) return trouble(options, "the camera's buffers cannot be mapped", errno);
    auto request = camera_->createRequest(requests_.size());
    if (!request || request->addBuffer(stream_, buffer.get()) != 0)
      return trouble(options, "the camera takes no request", ENOMEM);
    mapped_.push_back(std::move(mapped));
    requests_.push_back(std::move(request));
  }
  return {};
}

Outcome<libcamera::ControlList> LibcameraSession::choose_controls(const LibcameraOptions& options) {
  const libcamera::ControlInfoMap& known = camera_->controls();
  libcamera::ControlList set(known);
  if (options.exposure_us || options.gain) {
    switch (take_over_exposure(known, options.exposure_us.has_value(), options.gain.has_value(), set)) {
      case ExposureTaken::kAsAsked: break;
      case ExposureTaken::kBoth:
        if (!options.exposure_us || !options.gain)
          notes_.push_back(std::string(options.gain ? "exposure" : "gain") +
                           " stays as the camera has it: it has one switch for both");
        break;
      case ExposureTaken::kNone:
        if (has(known, controls::ExposureTime))
          notes_.push_back("automatic exposure cannot be switched off: the camera has no such control");
        break;
    }
  } else {
    notes_.push_back("exposure and gain left to the camera");
  }
  if (has(known, controls::AwbEnable)) set.set(controls::AwbEnable, false);
  concerns_ = neutral_image(known, options, set, notes_);
  exposure_us_ = 0;
  if (options.exposure_us) {
    if (has(known, controls::ExposureTime)) {
      exposure_us_ =
          inside(known, controls::ExposureTime, static_cast<std::int32_t>(*options.exposure_us), "exposure", " us", notes_);
      set.set(controls::ExposureTime, static_cast<std::int32_t>(exposure_us_));
    } else {
      notes_.push_back("exposure cannot be set: the camera has no such control; frames are timed as if it were " +
                       std::to_string(*options.exposure_us) + " us");
    }
  }
  if (options.gain) {
    if (has(known, controls::AnalogueGain))
      set.set(controls::AnalogueGain,
              inside(known, controls::AnalogueGain, static_cast<float>(*options.gain), "gain", "", notes_));
    else
      notes_.push_back("gain cannot be set: the camera has no such control");
  }
  sets_rate_ = false;
  if (!options.rate_hz) return set;
  if (!has(known, controls::FrameDurationLimits)) {
    notes_.push_back("frame rate cannot be set: the camera has no such control");
    return set;
  }
  sets_rate_ = true;
  std::int64_t duration_us = std::llround(1e6 / *options.rate_hz);
  const libcamera::ControlInfo& info = known.at(&controls::FrameDurationLimits);
  const std::int64_t low = info.min().isNone() ? 0 : info.min().get<std::int64_t>();
  const std::int64_t high = info.max().isNone() ? 0 : info.max().get<std::int64_t>();
  if (low < high && (duration_us < low || duration_us > high)) {
    const std::int64_t nearest = std::clamp(duration_us, low, high);
    const auto rate = [](std::int64_t us) { return number_text(std::round(1e9 / static_cast<double>(us)) / 1000) + " Hz"; };
    if (options.rate_required && std::abs(nearest - duration_us) * 100 > duration_us)
      return Problem{Exit::kDevice,
                     "the camera does not offer this frame rate",
                     where_of(options),
                     number_text(*options.rate_hz) + " Hz",
                     rate(high) + " to " + rate(low),
                     "set camera.frame_rate_hz inside this range"};
    notes_.push_back("frame rate " + rate(nearest) + ", the nearest that the camera offers");
    duration_us = nearest;
  }
  const std::array<std::int64_t, 2> limits{duration_us, duration_us};
  set.set(controls::FrameDurationLimits, libcamera::Span<const std::int64_t, 2>(limits));
  return set;
}

void LibcameraSession::stop() noexcept {
  {
    const std::lock_guard lock(mutex_);
    streaming_ = false;
  }
  mapped_.clear();
  if (!camera_) return;
  const auto disconnect = [&] {
    camera_->requestCompleted.disconnect(this);
    camera_->disconnected.disconnect(this);
  };
  if (acquired_ && (gone_.load(std::memory_order_acquire) || manager_->get(id_) != camera_)) {
    disconnect();
    abandon();
  } else {
    static_cast<void>(camera_->stop());  // completes all requests as cancelled
    disconnect();                        // not before: a slot that goes while libcamera's thread calls it is freed memory
    requests_.clear();
    if (allocator_ && stream_ != nullptr) static_cast<void>(allocator_->free(stream_));
    allocator_.reset();
    configuration_.reset();
    if (acquired_) static_cast<void>(camera_->release());
  }
  stream_ = nullptr;
  acquired_ = false;
  camera_.reset();
}

// libcamera ends the process by an assertion when a removed camera with requests under way is stopped (0.0.3, vimc). What
// it still refers to is kept for good instead: some buffers a removal.
void LibcameraSession::abandon() noexcept {
  struct Abandoned {
    std::shared_ptr<libcamera::Camera> camera;
    std::unique_ptr<libcamera::CameraConfiguration> configuration;
    std::unique_ptr<libcamera::FrameBufferAllocator> allocator;
    std::vector<std::unique_ptr<libcamera::Request>> requests;
    Abandoned* before;
  };
  static Abandoned* all = nullptr;  // never deleted
  all = new Abandoned{std::move(camera_), std::move(configuration_), std::move(allocator_), std::move(requests_), all};
  requests_.clear();
}

void LibcameraSession::wake() noexcept {
  const std::uint64_t one = 1;
  static_cast<void>(!::write(wakeup_.get(), &one, sizeof one));  // a full counter wakes as well
}

void LibcameraSession::completed(libcamera::Request* request) {
  if (!streaming_.load(std::memory_order_acquire)) return;  // being stopped
  CompletedRequest* slot = completed_.back();
  if (slot == nullptr) return;  // cannot be: more slots than requests
  *slot = {};
  slot->buffer = static_cast<std::uint32_t>(request->cookie());
  slot->good = request->status() == libcamera::Request::RequestComplete;
  if (const libcamera::FrameBuffer* buffer = request->findBuffer(stream_)) {
    const libcamera::FrameMetadata& frame = buffer->metadata();
    slot->good = slot->good && frame.status == libcamera::FrameMetadata::FrameSuccess;
    slot->numbered = frame.status != libcamera::FrameMetadata::FrameCancelled;
    slot->sequence = frame.sequence;
    slot->stamp_ns = slot->numbered ? static_cast<std::int64_t>(frame.timestamp) : 0;
  }
  if (const auto stamp = request->metadata().get(controls::SensorTimestamp)) slot->stamp_ns = *stamp;
  if (const auto exposure = request->metadata().get(controls::ExposureTime)) slot->exposure_us = *exposure;
  completed_.push();
  wake();
}

void LibcameraSession::disconnected() {
  gone_.store(true, std::memory_order_release);
  wake();
}

LibcameraSession::Ready LibcameraSession::wait(std::chrono::nanoseconds timeout) noexcept {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    if (completed_.front() != nullptr) return Ready::kFrame;
    if (gone_.load(std::memory_order_acquire)) return Ready::kGone;
    const auto left =
        std::max(std::chrono::nanoseconds(0), std::chrono::nanoseconds(deadline - std::chrono::steady_clock::now()));
    const timespec time = timespec_of(left.count());
    pollfd asked{wakeup_.get(), POLLIN, 0};
    if (::ppoll(&asked, 1, &time, nullptr) == 0) return Ready::kTimeout;
    std::uint64_t count = 0;
    static_cast<void>(!::read(wakeup_.get(), &count, sizeof count));
  }
}

bool LibcameraSession::take(CompletedRequest& request) noexcept {
  const CompletedRequest* front = completed_.front();
  if (front == nullptr) return false;
  request = *front;
  completed_.pop();
  borrowed_.fetch_add(1, std::memory_order_acq_rel);
  return true;
}

void LibcameraSession::give_back(std::uint32_t buffer) noexcept {
  {
    const std::lock_guard lock(mutex_);
    if (streaming_.load(std::memory_order_acquire) && !gone_.load(std::memory_order_acquire) && buffer < requests_.size()) {
      libcamera::Request& request = *requests_[buffer];
      request.reuse(libcamera::Request::ReuseBuffers);
      if (camera_->queueRequest(&request) != 0) gone_.store(true, std::memory_order_release);
    }
  }
  borrowed_.fetch_sub(1, std::memory_order_acq_rel);
}

}  // namespace srd
