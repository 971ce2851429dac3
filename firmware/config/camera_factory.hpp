// SPDX-License-Identifier: Apache-2.0
// The one place that makes a camera from a configuration.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "drivers/camera/camera.hpp"
#include "drivers/camera/simulator/scene.hpp"
#include "firmware/config/node_config.hpp"

namespace srd::firmware {

// What the simulator renders; none for other kinds of camera. kInput when the scene's file cannot be used, or a
// recording's folder is not there. config.camera is set.
[[nodiscard]] Outcome<std::optional<Scene>> scene_of(const NodeConfig& config);

// What a camera has to fit.
struct CameraPlace {
  int width = 0, height = 0;                                // px, of the calibration
  std::int32_t centre_row = FrameTiming::kWholeHeight / 2;  // through the pattern's centre, see FrameTiming::row_fraction
};

// Not started: devices are opened by Camera::start. kUsage for an image size that is not the calibration's, kDevice for a
// kind of camera that this build does not have.
[[nodiscard]] Outcome<std::unique_ptr<Camera>> make_camera(const NodeConfig& config, const std::optional<Scene>& scene,
                                                           const CameraPlace& place);

// For a person: the kinds, then every camera that is there, with what it offers.
[[nodiscard]] std::string list_cameras();

}  // namespace srd::firmware
