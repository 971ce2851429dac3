// SPDX-License-Identifier: Apache-2.0
// A V4L2 capture device through the camera interface.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "drivers/camera/camera.hpp"
#include "drivers/camera/frame_pool.hpp"
#include "drivers/camera/frame_sequence.hpp"
#include "drivers/camera/gray_jpeg.hpp"
#include "drivers/camera/stamp_gate.hpp"
#include "drivers/camera/v4l2/v4l2_plan.hpp"
#include "drivers/camera/v4l2/v4l2_stream.hpp"

namespace srd {

struct V4l2CameraOptions {
  V4l2Ask ask;
  // exposure_ns: what the configuration says; the device's own answer goes before it. mark: see stamp.
  FrameTiming timing;
  std::optional<StampMark> stamp;  // none: what the driver says of its stamps
  bool trigger_input = false;      // frames come when the sensor is triggered: their absence is no fault
};

// GREY and NV12 frames are the driver's own buffers, given back to it by give_back; other formats are converted once
// into buffers of this class. A compressed frame that is not whole is a bad one, counted as an error buffer. Frames have the driver's clock; a driver that stamps nothing gives the time of arrival
// (monotonic), and so does a stamp that says it is monotonic and cannot be true (stamp_gate.hpp; counted). Sequence numbers go on over their 32 bits, and over reconnects by the time that passed.
// A device that goes away (or gives nothing for 20 periods, 2 s at least, without a trigger) is closed as soon as every
// frame is given back, and opened again with the settings of the start, at most one try a call and five a second.
class V4l2Camera final : public Camera {
 public:
  explicit V4l2Camera(V4l2CameraOptions options, std::unique_ptr<V4l2Port> port = system_v4l2_port());
  ~V4l2Camera() override;

  // kDevice, with what the device offers.
  [[nodiscard]] Outcome<void> start() override;
  [[nodiscard]] Capture next(CameraFrame& frame, Nanoseconds timeout) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  void stop() noexcept override;
  [[nodiscard]] int width() const override { return plan_.settings.width / plan_.format.reduction(); }
  [[nodiscard]] int height() const override { return plan_.settings.height / plan_.format.reduction(); }
  [[nodiscard]] int buffer_count() const override { return buffers_; }
  [[nodiscard]] bool live() const override { return true; }
  [[nodiscard]] FrameTiming timing() const override { return timing_; }
  [[nodiscard]] std::string summary() const override;
  [[nodiscard]] std::string last_words() const override;
  [[nodiscard]] std::vector<std::string> image_concerns() const override { return plan_.concerns; }
  [[nodiscard]] Nanoseconds conversion_time() const override {
    return Nanoseconds(conversions_ > 0 ? converting_ns_ / conversions_ : 0);
  }

 private:
  [[nodiscard]] int least_stride() const { return row_bytes(plan_.format.layout, plan_.settings.width); }
  [[nodiscard]] bool make_gray(const V4l2Taken& taken, std::uint32_t own_buffer) noexcept;
  [[nodiscard]] Capture take(CameraFrame& frame, std::uint32_t own_buffer) noexcept;
  [[nodiscard]] Capture recover(Nanoseconds timeout) noexcept;
  Capture lose(V4l2Failure why) noexcept;
  void streaming() noexcept;
  void note_waiting() noexcept;
  [[nodiscard]] std::int64_t stall_ns() const noexcept;

  V4l2CameraOptions options_;
  std::unique_ptr<V4l2Port> port_;
  V4l2Stream stream_;
  V4l2Plan plan_;
  FrameTiming timing_;
  FramePool own_;  // of converted images
  std::unique_ptr<GrayJpegDecoder> jpeg_;
  std::int64_t converting_ns_ = 0, conversions_ = 0;
  FrameSequence sequence_;
  StampGate gate_;
  int buffers_ = 0;
  bool started_ = false, disconnected_ = false, reconnected_ = false, stalled_ = false;
  std::int64_t last_frame_ns_ = 0;  // monotonic; of the start too
  std::int64_t next_try_ns_ = 0;
  V4l2Failure why_;  // of being away
  bool stopped_disconnected_ = false;
};

}  // namespace srd
