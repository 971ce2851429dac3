// SPDX-License-Identifier: Apache-2.0
// A build without libcamera says so.
#include "drivers/camera/libcamera/libcamera_driver.hpp"

namespace srd {

bool libcamera_is_built() { return false; }

Outcome<std::unique_ptr<Camera>> make_libcamera_camera(const LibcameraOptions& options) {
  return Problem{Exit::kDevice,
                 "this build has no libcamera",
                 options.id.empty() ? "libcamera" : "libcamera:" + options.id,
                 "an srd-node built with libcamera",
                 "one built without",
                 "use v4l2:/dev/videoN, or build again with libcamera-dev installed"};
}

std::string list_libcamera_cameras() { return "libcamera cameras:\n  this build has no libcamera\n"; }

}  // namespace srd
