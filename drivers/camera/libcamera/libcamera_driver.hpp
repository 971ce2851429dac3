// SPDX-License-Identifier: Apache-2.0
// Cameras of the board through libcamera, as far as this build has it. No libcamera header is seen from here.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "drivers/camera/camera.hpp"

namespace srd {

struct LibcameraOptions {
  std::string id;             // as listed; empty: the first camera
  int width = 0, height = 0;  // px
  std::optional<double> rate_hz;
  bool rate_required = false;               // a camera that cannot do rate_hz to 1 % is refused
  std::optional<std::int64_t> exposure_us;  // none: automatic exposure goes on
  std::optional<double> gain;               // analogue, 1 and more; none: automatic, unless exposure_us is given
  std::optional<double> sharpness;          // none: 0, which is none; 1: what the camera's maker thinks normal
  std::optional<double> focus;              // 1/m; none: the lens stays where it is
  int buffers = 4;
  FrameTiming timing;  // mark: of SensorTimestamp. The exposure that a frame reports goes before exposure_ns
  bool trigger_input = false;
};

[[nodiscard]] bool libcamera_is_built();
// Not started. kDevice when this build has no libcamera. The camera: frames of R8, YUV420 and NV12 are read in the
// camera's own buffers; YUYV, R10, R12, R16 and RGB are converted once. Frames that libcamera cancels or marks are bad;
// a camera that is removed is taken up again when it returns, with the configuration of the start (libcamera itself
// uses the heap, for each request too: on its thread and in give_back).
[[nodiscard]] Outcome<std::unique_ptr<Camera>> make_libcamera_camera(const LibcameraOptions& options);
// Every camera: id, model, formats and sizes. Ends with a line end.
[[nodiscard]] std::string list_libcamera_cameras();

}  // namespace srd
