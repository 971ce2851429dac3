// SPDX-License-Identifier: Apache-2.0
// What libcamera's image processing would do to edges, grey levels and the lens, switched off where the camera has it.
#pragma once

#include <string>
#include <vector>

#include <libcamera/controls.h>

#include "drivers/camera/libcamera/libcamera_driver.hpp"

namespace srd {

// Adds to set: no sharpening (or as asked), no noise reduction, contrast, brightness and gamma neutral, the lens by hand.
// Controls are found by their names: which there are, and in which namespace, differs between the releases of libcamera.
// Gives what the camera goes on doing although it should not; notes: what a person should know.
[[nodiscard]] std::vector<std::string> neutral_image(const libcamera::ControlInfoMap& known, const LibcameraOptions& options,
                                                     libcamera::ControlList& set, std::vector<std::string>& notes);

}  // namespace srd
