// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_camera.hpp"

#include <algorithm>
#include <cerrno>

#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kTimeoutLeast = 1000 * kMillisecond, kTimeoutPeriods = 4;
constexpr std::int64_t kStallLeast = 2000 * kMillisecond, kStallPeriods = 20;
constexpr std::int64_t kBetweenTries = 200 * kMillisecond;

}  // namespace

V4l2Camera::V4l2Camera(V4l2CameraOptions options, std::unique_ptr<V4l2Port> port)
    : options_(std::move(options)), port_(std::move(port)), stream_(*port_, faults_) {
  options_.ask.buffers = std::clamp(options_.ask.buffers, 3, FramePool::kMaxBuffers);
}

V4l2Camera::~V4l2Camera() { stop(); }

Outcome<void> V4l2Camera::start() {
  stop();
  auto plan = plan_capture(*port_, options_.ask);
  if (!plan) {
    port_->close();
    return plan.error();
  }
  plan_ = std::move(plan).value();
  if (const V4l2Failure failure = stream_.start(plan_.settings, least_stride()); failure.any())
    return problem_of(failure, options_.ask.path);
  buffers_ = stream_.buffers();
  if (!plan_.format.zero_copy()) {
    buffers_ = options_.ask.buffers;
    own_.reserve(width(), height(), buffers_);
  }
  jpeg_ = plan_.format.compressed() ? std::make_unique<GrayJpegDecoder>(width(), height()) : nullptr;
  converting_ns_ = conversions_ = 0;
  timing_ = options_.timing;
  if (plan_.exposure_ns > 0) timing_.exposure_ns = plan_.exposure_ns;
  timing_.mark = options_.stamp.value_or(stream_.mark());
  sequence_ = FrameSequence(plan_.settings.period_ns());
  gate_ = StampGate(plan_.settings.period_ns());
  gate_.begin(port_->now_ns());
  started_ = true;
  disconnected_ = reconnected_ = stopped_disconnected_ = false;
  why_ = {};
  streaming();
  return {};
}

void V4l2Camera::streaming() noexcept {
  last_frame_ns_ = port_->now_ns();
  stalled_ = false;
}

Capture V4l2Camera::next(CameraFrame& frame, Nanoseconds timeout) noexcept {
  if (!started_) return Capture::kEnd;
  const std::int64_t deadline = port_->now_ns() + timeout.count();
  const auto left = [&] { return Nanoseconds(std::max<std::int64_t>(0, deadline - port_->now_ns())); };
  if (disconnected_)
    if (const Capture recovered = recover(timeout); recovered != Capture::kFrame) return recovered;

  std::uint32_t own_buffer = 0;
  if (!plan_.format.zero_copy()) {
    // Without a place for the image the driver's buffers stay full: the frames that it drops are a gap in the sequence.
    const auto found = own_.acquire(std::chrono::steady_clock::now() + left());
    if (!found) return Capture::kTimeout;
    own_buffer = *found;
  }
  const auto without_frame = [&](Capture what) {
    if (!plan_.format.zero_copy()) own_.release(own_buffer);
    return what;
  };
  stream_.requeue_idle();
  for (;;) {
    const std::int64_t wait_from = port_->now_ns();
    const V4l2Port::Ready ready = port_->wait(left());
    gate_.waited(wait_from, port_->now_ns());
    switch (ready) {
      case V4l2Port::Ready::kError: return without_frame(lose({V4l2Step::kDone, EIO}));
      case V4l2Port::Ready::kTimeout:
        note_waiting();
        if (!options_.trigger_input && stream_.queued() > 0 && port_->now_ns() - last_frame_ns_ > stall_ns())
          return without_frame(lose({V4l2Step::kStalled, 0}));
        return without_frame(Capture::kTimeout);
      case V4l2Port::Ready::kFrame: break;
    }
    const Capture taken = take(frame, own_buffer);
    if (taken == Capture::kTimeout && left().count() > 0) continue;  // ready, yet nothing to take
    return taken == Capture::kFrame ? taken : without_frame(taken);
  }
}

Capture V4l2Camera::take(CameraFrame& frame, std::uint32_t own_buffer) noexcept {
  V4l2Taken taken;
  switch (stream_.take(taken)) {
    case V4l2Stream::Take::kNothing: return Capture::kTimeout;
    case V4l2Stream::Take::kGone: return lose({V4l2Step::kDone, EIO});
    case V4l2Stream::Take::kTaken: break;
  }
  streaming();
  if (reconnected_) {
    reconnected_ = false;
    count_one(faults_.reconnects);
  }
  frame = {};
  const std::int64_t arrival_ns = last_frame_ns_;
  const bool claims_monotonic = stream_.clock() == ClockId::kMonotonic;
  const bool by_arrival = claims_monotonic ? !gate_.possible(taken.stamp_ns, arrival_ns) : taken.stamp_ns == 0;
  frame.clock = by_arrival ? ClockId::kMonotonic : stream_.clock();
  const std::int64_t stamp_ns = by_arrival ? arrival_ns : taken.stamp_ns;
  if (claims_monotonic) gate_.gave(stamp_ns);
  // A damaged frame has no image to be timed: it is counted as damaged only.
  if (by_arrival && claims_monotonic && !taken.damaged) count_one(faults_.bad_stamps);
  frame.sequence = sequence_.next(taken.sequence, frame.clock == ClockId::kMonotonic ? stamp_ns : arrival_ns);
  FrameTiming timing = timing_;
  if (by_arrival) timing.mark = StampMark::kFrameEnd;  // what the arrival is the time of, whatever the stamps mark
  frame.time_ns = timing.middle_ns(stamp_ns);
  frame.exposure_us = static_cast<std::uint32_t>(timing_.exposure_ns / 1000);
  if (taken.damaged) {
    count_one(faults_.error_buffers);
    stream_.give_back(taken.buffer);
    return Capture::kBadFrame;
  }
  if (plan_.format.zero_copy()) {
    frame.image = {stream_.pixels(taken.buffer), width(), height(), stream_.stride_bytes()};
    frame.buffer = taken.buffer;
    return Capture::kFrame;
  }
  const bool whole = make_gray(taken, own_buffer);
  stream_.give_back(taken.buffer);
  if (!whole) {
    count_one(faults_.error_buffers);
    return Capture::kBadFrame;
  }
  frame.image = own_.view(own_buffer);
  frame.buffer = own_buffer;
  return Capture::kFrame;
}

bool V4l2Camera::make_gray(const V4l2Taken& taken, std::uint32_t own_buffer) noexcept {
  const std::int64_t before_ns = port_->now_ns();
  const std::uint8_t* from = stream_.pixels(taken.buffer);
  std::uint8_t* to = own_.pixels(own_buffer);
  const V4l2PixelFormat& format = plan_.format;
  bool whole = true;
  if (jpeg_)
    whole = jpeg_->decode({from, taken.bytes}, to, own_.stride_bytes());
  else if (format.mosaic != Mosaic::kNone)
    halve_mosaic(format.layout, format.bits, format.mosaic, options_.ask.mosaic, from, stream_.stride_bytes(), to,
                 own_.stride_bytes(), width(), height());
  else
    convert_to_gray(format.layout, format.bits, from, stream_.stride_bytes(), to, own_.stride_bytes(), width(), height());
  converting_ns_ += port_->now_ns() - before_ns;
  ++conversions_;
  return whole;
}

void V4l2Camera::give_back(const CameraFrame& frame) noexcept {
  if (frame.image.pixels == nullptr) return;
  if (plan_.format.zero_copy())
    stream_.give_back(frame.buffer);
  else
    own_.release(frame.buffer);
}

std::int64_t V4l2Camera::stall_ns() const noexcept { return std::max(kStallLeast, kStallPeriods * plan_.settings.period_ns()); }

void V4l2Camera::note_waiting() noexcept {
  if (options_.trigger_input || stalled_ || stream_.queued() == 0) return;
  if (port_->now_ns() - last_frame_ns_ <= std::max(kTimeoutLeast, kTimeoutPeriods * plan_.settings.period_ns())) return;
  stalled_ = true;
  count_one(faults_.timeouts);
}

Capture V4l2Camera::lose(V4l2Failure why) noexcept {
  disconnected_ = true;
  if (!reconnected_) count_one(faults_.disconnects);
  reconnected_ = false;
  if (why.any()) why_ = why;
  sequence_.restart();
  return Capture::kDisconnected;
}

// One try at most. kFrame: streams again.
Capture V4l2Camera::recover(Nanoseconds timeout) noexcept {
  const std::int64_t deadline = port_->now_ns() + timeout.count();
  const auto wait_until = [&](std::int64_t time_ns) {
    const std::int64_t until = std::min(time_ns, deadline);
    if (const std::int64_t now = port_->now_ns(); until > now) port_->pause(Nanoseconds(until - now));
  };
  // Borrowed images lie in the mappings.
  if (stream_.borrowed() > 0) {
    wait_until(port_->now_ns() + kMillisecond);
    if (stream_.borrowed() > 0) return Capture::kDisconnected;
  }
  stream_.stop();
  if (next_try_ns_ > deadline) {
    wait_until(deadline);
    return Capture::kDisconnected;
  }
  wait_until(next_try_ns_);
  // Also after a try that seemed to work: a device may start and fail at once.
  next_try_ns_ = port_->now_ns() + kBetweenTries;
  V4l2Failure failure;
  if (const int error = port_->open(options_.ask.path.c_str()); error != 0)
    failure = {V4l2Step::kOpen, error};
  else
    failure = stream_.start(plan_.settings, least_stride());
  if (failure.any()) {
    port_->close();
    why_ = failure;
    wait_until(next_try_ns_);
    return Capture::kDisconnected;
  }
  disconnected_ = false;
  reconnected_ = true;  // counted as back with its first frame
  why_ = {};
  streaming();
  gate_.begin(last_frame_ns_);
  return Capture::kFrame;
}

void V4l2Camera::stop() noexcept {
  stopped_disconnected_ = started_ && disconnected_;
  started_ = false;
  stream_.stop();
}

std::string V4l2Camera::summary() const {
  if (!started_) return {};
  std::string text = "camera    " + plan_.identity.card + " (" + plan_.identity.driver + ", " + plan_.identity.bus + "), " +
                     std::to_string(width()) + " x " + std::to_string(height()) + " " + std::string(plan_.format.name);
  if (plan_.rate_hz > 0)
    text += " at " + number_text(static_cast<double>(static_cast<std::int64_t>(plan_.rate_hz * 1000 + 0.5)) / 1000) + " Hz";
  if (plan_.format.compressed())
    text += ", decoded";
  else if (plan_.format.mosaic != Mosaic::kNone)
    text += std::string(", halved by ") + (options_.ask.mosaic == MosaicGray::kAll ? "all four" : "the two green") +
            " pixels of a cell";
  else
    text += plan_.format.zero_copy() ? ", read in place" : ", converted to grey";
  text += ", " + std::to_string(buffers_) + " buffers\n";
  text += "stamps    " + std::string(stream_.clock() == ClockId::kMonotonic ? "monotonic" : "of an unknown clock") +
          ", of the " + std::string(to_string(timing_.mark)) + (options_.stamp ? " (as configured)" : "") + "\n";
  for (const std::string& note : plan_.notes) text += "note      " + note + "\n";
  return text;
}

std::string V4l2Camera::last_words() const {
  if (!stopped_disconnected_) return {};
  const std::string why = failure_text(why_);
  return "camera    " + options_.ask.path + " went away and did not come back" + (why.empty() ? "" : ": " + why) + "\n";
}

}  // namespace srd
