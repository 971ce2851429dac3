// SPDX-License-Identifier: Apache-2.0
#include "firmware/loop/frame_loop.hpp"

#include <chrono>
#include <thread>

#include "drivers/support/system_clock.hpp"
#include "proto/frame_from_estimate.hpp"

namespace srd::firmware {

namespace {

constexpr std::size_t kRingFrames = 64;  // more than any camera has buffers
constexpr auto kCaptureTimeout = std::chrono::milliseconds(100);
constexpr auto kWaitForRoom = std::chrono::milliseconds(1);
constexpr int kPatienceAfterStop = 1000;  // turns of kWaitForRoom, for all records together

[[nodiscard]] std::uint32_t microseconds(std::int64_t ns) { return static_cast<std::uint32_t>(ns / 1000); }

// The wall clock's reading at a sensor time, 0 for clocks that have no relation to it.
void set_wall_time(proto::Stamp& stamp) {
  clockid_t clock = CLOCK_REALTIME;
  switch (stamp.clock) {
    case ClockId::kMonotonic: clock = CLOCK_MONOTONIC; break;
    case ClockId::kBoottime: clock = CLOCK_BOOTTIME; break;
    case ClockId::kRealtime: break;
    default:
      stamp.wall_time_ns = 0;
      stamp.wall_uncertainty_ns = 0;
      return;
  }
  // The two readings are not at one instant: half the time between them is the uncertainty.
  const std::int64_t before = clock_ns(CLOCK_REALTIME);
  const std::int64_t sensor = clock_ns(clock);
  const std::int64_t after = clock_ns(CLOCK_REALTIME);
  stamp.wall_time_ns = stamp.sensor_time_ns + (before + (after - before) / 2 - sensor);
  stamp.wall_uncertainty_ns = static_cast<std::uint64_t>(after > before ? (after - before) / 2 + 1 : 1);
}

proto::NodeState state_of(dsp::TrackState state) {
  switch (state) {
    case dsp::TrackState::kSearching: return proto::NodeState::kSearching;
    case dsp::TrackState::kTracking: return proto::NodeState::kTracking;
    case dsp::TrackState::kLost: return proto::NodeState::kLost;
  }
  return proto::NodeState::kSearching;
}

void count(std::atomic<std::uint64_t>& counter, std::uint64_t more = 1) { counter.fetch_add(more, std::memory_order_relaxed); }

}  // namespace

FrameLoop::FrameLoop(Camera& camera, dsp::SurfaceTracker<float>& tracker, const FrameLoopOptions& options, RecordSink sink)
    : camera_(camera),
      tracker_(tracker),
      options_(options),
      sink_(std::move(sink)),
      ring_(kRingFrames),
      patience_after_stop_(kPatienceAfterStop) {
  record_.model = tracker.model();
  record_.metric = tracker.metric();
  record_.refractive_index = tracker.media().water;
  for (int i = 0; i < tracker.media().n_layers; ++i)
    (void)record_.plates.push(tracker.media().layers[static_cast<std::size_t>(i)]);
  if (options.doubts != nullptr) {
    record_.systematic.pose_day = options.doubts->pose_date;
    record_.systematic.calibration_day = options.doubts->calibration_date;
  }
  const dsp::Vec2<double> centre = tracker.pattern().centre();
  record_.centre_x_mm = static_cast<float>(centre.x());
  record_.centre_y_mm = static_cast<float>(centre.y());
  record_.pattern_x_mm = static_cast<float>((tracker.pattern().rows() - 1) * tracker.pattern().square());
  record_.pattern_y_mm = static_cast<float>((tracker.pattern().columns() - 1) * tracker.pattern().square());
  counters_.state = static_cast<std::uint8_t>(proto::NodeState::kStarting);
}

void FrameLoop::capture() {
  CameraFrame frame;
  bool connected = true, ended = false;
  std::uint64_t taken = 0;
  while (!ended && !stopping_.load(std::memory_order_relaxed) && (options_.frames == 0 || taken < options_.frames)) {
    count(counters_.calls);
    switch (camera_.next(frame, kCaptureTimeout)) {
      case Capture::kFrame:
        connected = true;
        ++taken;
        if (options_.light != nullptr) options_.light->captured(frame);
        hand_over(frame, true);
        break;
      case Capture::kBadFrame:
        ++taken;
        hand_over(frame, false);
        break;
      case Capture::kTimeout: break;
      case Capture::kDisconnected:
        if (connected) count(counters_.disconnects);
        connected = false;
        break;
      case Capture::kEnd: ended = true; break;
    }
    counters_.disconnected.store(!connected, std::memory_order_relaxed);
  }
  captured_all_.store(true, std::memory_order_release);
  handed_over_.fetch_add(1, std::memory_order_release);
  handed_over_.notify_one();
}

void FrameLoop::hand_over(const CameraFrame& frame, bool usable) {
  count(counters_.captured);
  // The ring holds more frames than the camera has buffers, so only bad frames, which have none, can find it full.
  Captured* slot = ring_.back();
  while (slot == nullptr) {
    std::this_thread::sleep_for(kWaitForRoom);
    slot = ring_.back();
  }
  *slot = {frame, usable};
  ring_.push();
  handed_over_.fetch_add(1, std::memory_order_release);
  handed_over_.notify_one();
  capture_faults_.frame();
}

void FrameLoop::process() {
  for (;;) {
    const std::uint32_t seen = handed_over_.load(std::memory_order_acquire);
    Captured* captured = ring_.front();
    if (captured == nullptr) {
      if (captured_all_.load(std::memory_order_acquire) && ring_.front() == nullptr) return;
      handed_over_.wait(seen, std::memory_order_acquire);
      continue;
    }
    Captured taken = *captured;
    ring_.pop();
    count_gap(taken.frame);
    if (taken.usable && options_.light != nullptr) options_.light->label(taken.frame);
    if (taken.usable && options_.on_frame) options_.on_frame(taken.frame);
    if (camera_.live() && taken.usable && ring_.front() != nullptr) {
      // A newer frame waits: the older one is late already.
      camera_.give_back(taken.frame);
      count(counters_.dropped_late);
      ++dropped_before_;
      continue;
    }
    make_record(taken);
    deliver();
    process_faults_.frame();
  }
}

// Of every frame, before it is known whether it is processed: one that is late is no gap of the source.
void FrameLoop::count_gap(const CameraFrame& frame) {
  if (any_sequence_ && frame.sequence > next_sequence_) {
    const std::uint64_t gap = frame.sequence - next_sequence_;
    count(counters_.dropped_by_source, gap);
    dropped_before_ += static_cast<std::uint32_t>(std::min<std::uint64_t>(gap, UINT32_MAX / 2));
  }
  any_sequence_ = true;
  next_sequence_ = frame.sequence + 1;
}

void FrameLoop::make_record(const Captured& captured) {
  const CameraFrame& frame = captured.frame;
  const std::int64_t begin = clock_ns(CLOCK_MONOTONIC);
  if (options_.deadline != nullptr) options_.deadline->start();
  record_.stamp.sensor_time_ns = frame.time_ns;
  record_.stamp.clock = frame.clock;
  set_wall_time(record_.stamp);
  record_.exposure_us = frame.exposure_us;
  record_.strobe = frame.strobe;
  record_.source_sequence = frame.sequence;
  record_.dropped_before = dropped_before_;
  record_.coefficients.resize(0);
  record_.information = {};
  record_.systematic.deviation.resize(0);
  record_.systematic.height_mm = 0;
  record_.mean_error = record_.reprojection_rms_px = 0;
  record_.detection_us = record_.estimation_us = 0;
  record_.stop = dsp::Stop::kTooFewCorners;
  record_.at_bound = false;
  record_.iterations = record_.corners_expected = record_.corners_found = record_.corners_used = 0;
  if (!captured.usable) {
    record_.status = proto::FrameStatus::kBadFrame;
    count(counters_.bad);
  } else if (frame.strobe == StrobePhase::kDark) {
    camera_.give_back(frame);
    record_.status = proto::FrameStatus::kDark;
    count(counters_.dark);
  } else {
    const dsp::FrameResult<float>& result = tracker_.process(std::span(&frame.image, 1), frame.time_ns);
    // Once: an eighth of one image.
    if (!result.has_surface() && !first_image_.taken()) first_image_ = ImageSketch(frame.image);
    camera_.give_back(frame);
    record_.corners_expected = static_cast<std::uint32_t>(result.expected);
    record_.corners_found = static_cast<std::uint32_t>(result.found);
    const auto before = static_cast<proto::NodeState>(counters_.state.load(std::memory_order_relaxed));
    const proto::NodeState now = state_of(result.state);
    if (before == proto::NodeState::kTracking && now != proto::NodeState::kTracking) count(counters_.lost_tracks);
    counters_.state.store(static_cast<std::uint8_t>(now), std::memory_order_relaxed);
    if (result.acquired) count(counters_.acquired);
    if (result.estimate.stop == dsp::Stop::kDeadline) count(counters_.hurried);
    record_.detection_us = microseconds(result.detection_ns);
    record_.estimation_us = microseconds(result.estimation_ns);
    if (result.status == dsp::TrackStatus::kSolverFailed) {
      record_.stop = result.estimate.stop;
      if (result.estimate.rank.singular()) {
        count(counters_.singular);
        last_singular_ = result.estimate.rank;
      }
    }
    if (result.has_estimate()) proto::set_estimate(result.estimate, record_.metric, record_);
    if (record_.has_surface()) add_systematic(result);
    if (!result.has_surface()) record_.status = proto::status_of(result);
    if (result.has_surface() && record_.has_surface()) count(counters_.surfaces);
  }
  record_.total_us = microseconds(clock_ns(CLOCK_MONOTONIC) - begin);
}

void FrameLoop::add_systematic(const dsp::FrameResult<float>& result) {
  if (options_.doubts == nullptr) return;
  dsp::SystematicWatch& watch = options_.doubts->watch;
  // A surface that its frame contradicts is none to follow.
  if (result.has_surface()) watch.follow(record_.coefficients, result.observations[0]);
  const dsp::Coefficients<double>& deviation = watch.deviation();
  constexpr double kMost = static_cast<double>(proto::SystematicErrors::kMost);
  if (deviation.size() != record_.coefficients.size() || !(deviation.maxCoeff() <= kMost) ||
      !(watch.height_deviation() <= kMost))
    return;
  record_.systematic.deviation = deviation.cast<float>();
  record_.systematic.height_mm = static_cast<float>(watch.height_deviation());
}

// A live camera does not wait: a record that finds no room is lost, and the next one says so. A recording waits for room, and
// after stop() a second more: a host that is gone must not keep the program.
void FrameLoop::deliver() {
  count(counters_.records);
  ++statuses_[static_cast<std::size_t>(record_.status)];
  while (!sink_(record_)) {
    if (camera_.live() || (stopping_.load(std::memory_order_relaxed) && --patience_after_stop_ < 0)) {
      count(counters_.dropped_transmit);
      ++dropped_before_;
      return;
    }
    std::this_thread::sleep_for(kWaitForRoom);
  }
  dropped_before_ = 0;
}

}  // namespace srd::firmware
