// SPDX-License-Identifier: Apache-2.0
// The frame's way on the board: capture -> process -> record, in two threads with a ring between them.
// After the threads run: no heap, no exception, no lock but the camera's own.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>

#include "drivers/camera/camera.hpp"
#include "drivers/camera/image_sketch.hpp"
#include "drivers/support/day.hpp"
#include "dsp/core/spsc_ring.hpp"
#include "dsp/pipeline/surface_tracker.hpp"
#include "dsp/pose/systematic_watch.hpp"
#include "firmware/loop/frame_deadline.hpp"
#include "firmware/loop/frame_light.hpp"
#include "firmware/realtime/page_faults.hpp"
#include "proto/messages.hpp"

namespace srd::firmware {

// Written by the loop's threads, read by any.
struct FrameCounters {
  std::atomic<std::uint64_t> captured{0};  // frames that the camera gave, bad ones too
  std::atomic<std::uint64_t> records{0};
  std::atomic<std::uint64_t> surfaces{0};           // records with a surface
  std::atomic<std::uint64_t> acquired{0};           // found by full detection
  std::atomic<std::uint64_t> lost_tracks{0};        // tracked in one frame and not in the next
  std::atomic<std::uint64_t> dropped_by_source{0};  // gaps in the camera's numbers
  std::atomic<std::uint64_t> dropped_late{0};       // live frames that a newer one overtook
  std::atomic<std::uint64_t> dropped_transmit{0};   // records given up: the sink had no room
  std::atomic<std::uint64_t> hurried{0};            // records whose fit the deadline ended
  std::atomic<std::uint64_t> singular{0};           // records whose corners do not determine the coefficients
  std::atomic<std::uint64_t> bad{0};                // frames without a usable image
  std::atomic<std::uint64_t> dark{0};               // frames without light, on purpose: not processed
  std::atomic<std::uint64_t> disconnects{0};
  std::atomic<std::uint64_t> calls{0};    // of the camera, answered or not
  std::atomic<bool> disconnected{false};  // the camera is, at the moment
  std::atomic<std::uint8_t> state{0};     // proto::NodeState
};

// Where records go. Called from the processing thread, never waits; false: no room now. Waiting, giving up and counting is
// the loop's alone.
using RecordSink = std::function<bool(const proto::CoefficientFrame&)>;

// Gets every usable frame before it is processed or dropped as late. Called from the processing thread; may not keep it.
using OnFrame = std::function<void(const CameraFrame&)>;

// How sure the camera is, and since when.
struct CameraDoubts {
  dsp::SystematicWatch watch;
  Day pose_date = 0;                      // 0: not known
  std::optional<Day> calibration_date{};  // none: the calibration counts as exact
};

struct FrameLoopOptions {
  std::uint64_t frames = 0;           // end after so many records; 0: at the camera's end
  CameraDoubts* doubts = nullptr;     // that records' systematic deviations come from; none: not known
  FrameDeadline* deadline = nullptr;  // that the tracker asks; started with every frame
  OnFrame on_frame{};                 // may be none
  FrameLight* light = nullptr;        // the strobe; none: frames keep the camera's labels
};

class FrameLoop {
 public:
  // camera is started; both outlive the loop.
  FrameLoop(Camera& camera, dsp::SurfaceTracker<float>& tracker, const FrameLoopOptions& options, RecordSink sink);

  // The capturing thread's whole life: returns at the camera's end, after the wanted frames, or when stopped.
  void capture();
  // The processing thread's whole life: returns when capture is over and every frame has its record.
  void process();
  // From any thread or a signal handler.
  void stop() { stopping_.store(true, std::memory_order_relaxed); }

  [[nodiscard]] const FrameCounters& counters() const { return counters_; }
  // Of the last singular frame; after process() has returned.
  [[nodiscard]] const dsp::RankReport& last_singular() const { return last_singular_; }
  [[nodiscard]] const PageFaults& capture_faults() const { return capture_faults_; }
  [[nodiscard]] const PageFaults& process_faults() const { return process_faults_; }
  // Frames by status; after process() has returned.
  [[nodiscard]] const std::array<std::uint64_t, proto::kFrameStatusCount>& statuses() const { return statuses_; }
  // Of the first image without a surface; after process() has returned.
  [[nodiscard]] const ImageSketch& first_image() const { return first_image_; }
  [[nodiscard]] const CameraCounters& camera_faults() const { return camera_.faults(); }
  [[nodiscard]] bool capturing() const { return !captured_all_.load(std::memory_order_acquire); }

 private:
  struct Captured {
    CameraFrame frame;
    bool usable = false;
  };
  void hand_over(const CameraFrame& frame, bool usable);
  void count_gap(const CameraFrame& frame);
  void make_record(const Captured& captured);
  void add_systematic(const dsp::FrameResult<float>& result);
  void deliver();

  Camera& camera_;
  dsp::SurfaceTracker<float>& tracker_;
  FrameLoopOptions options_;
  RecordSink sink_;
  SpscRing<Captured> ring_;
  FrameCounters counters_;
  PageFaults capture_faults_, process_faults_;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> captured_all_{false};
  // Waking the processing thread: a count that it waits on (futex), no lock.
  std::atomic<std::uint32_t> handed_over_{0};

  // Of the processing thread.
  proto::CoefficientFrame record_;
  dsp::RankReport last_singular_;
  std::array<std::uint64_t, proto::kFrameStatusCount> statuses_{};
  ImageSketch first_image_;
  std::uint32_t dropped_before_ = 0;
  int patience_after_stop_;  // turns of waiting for room
  std::uint64_t next_sequence_ = 0;
  bool any_sequence_ = false;
};

}  // namespace srd::firmware
