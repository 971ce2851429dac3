// SPDX-License-Identifier: Apache-2.0
// Strobe interface of the frame loop: captured() on the capture thread, label() on the process thread.
#pragma once

#include "drivers/camera/camera.hpp"

namespace srd::firmware {

class FrameLight {
 public:
  virtual ~FrameLight() = default;
  // The capturing thread has this frame. No heap, no lock.
  virtual void captured(const CameraFrame& frame) noexcept = 0;
  // The processing thread has it: says which light made it (strobe), and sets time_ns to the middle of a pulse. Frames
  // that are dark are not processed. No heap, no lock.
  virtual void label(CameraFrame& frame) noexcept = 0;
};

}  // namespace srd::firmware
