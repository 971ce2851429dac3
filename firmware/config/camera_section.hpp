// SPDX-License-Identifier: Apache-2.0
// [camera] of the configuration: where frames come from, and how a live camera is set. Keys: board/README.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "drivers/camera/frame_timing.hpp"
#include "drivers/camera/gray_conversion.hpp"
#include "drivers/support/problem.hpp"

namespace srd {
class TomlTable;
}

namespace srd::firmware {

struct NodeConfig;

// Where frames come from: "KIND" or "KIND:ARGUMENT".
struct CameraSource {
  std::string kind;
  std::string argument;
  [[nodiscard]] bool live() const { return kind == "v4l2" || kind == "libcamera"; }
  // As the configuration writes it.
  [[nodiscard]] std::string text() const { return argument.empty() ? kind : kind + ":" + argument; }
  [[nodiscard]] static Outcome<CameraSource> parse(const std::string& text);
  // "libcamera[:ID], v4l2:/dev/videoN, recording:FOLDER or simulator[:SEED]"
  [[nodiscard]] static std::string kinds();
};

// What is asked of a live camera; recordings and the simulator bring their own.
struct LiveCamera {
  bool rate_required = false;               // the file names a rate: a camera that cannot do it is refused
  std::string format = "auto";              // V4L2
  MosaicGray mosaic = MosaicGray::kGreen;   // V4L2, of a colour sensor's raw image
  std::optional<int> width, height;         // px; none: the calibration's
  std::optional<std::int64_t> exposure_us;  // none: left as the camera has it
  std::optional<double> gain;               // libcamera: analogue factor; V4L2: the device's units
  std::optional<double> sharpness;          // none: the least that the camera has
  std::optional<double> focus;              // libcamera: 1/m; V4L2: the device's units; none: the lens stays where it is
  int buffers = 4;
  Shutter shutter = Shutter::kGlobal;
  std::int64_t readout_us = 0;     // first row to last row
  std::optional<StampMark> stamp;  // none: what the driver says
  bool trigger_input = false;      // the sensor exposes when its trigger line is pulsed
};

// Fills camera, pace, frame_rate_hz, scene and live of config; complaints go to the table.
void read_camera(TomlTable camera, const std::filesystem::path& folder, NodeConfig& config);

}  // namespace srd::firmware
