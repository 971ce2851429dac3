// SPDX-License-Identifier: Apache-2.0
// Where libcamera's releases differ: 0.0.3 (Debian 12) and 0.4 (Debian 13). Nothing else of the driver asks for a version.
#pragma once

#include <libcamera/libcamera.h>
#include <libcamera/version.h>

#include <array>
#include <memory>

#define SRD_LIBCAMERA_AT_LEAST(major, minor) \
  (LIBCAMERA_VERSION_MAJOR > (major) || (LIBCAMERA_VERSION_MAJOR == (major) && LIBCAMERA_VERSION_MINOR >= (minor)))

namespace srd {

// 0.0.3 takes a vector of roles, later releases a span.
inline std::unique_ptr<libcamera::CameraConfiguration> configuration_for(libcamera::Camera& camera,
                                                                         libcamera::StreamRole role) {
#if SRD_LIBCAMERA_AT_LEAST(0, 1)
  const std::array<libcamera::StreamRole, 1> roles{role};
  return camera.generateConfiguration(roles);
#else
  return camera.generateConfiguration(libcamera::StreamRoles{role});
#endif
}

enum class ExposureTaken { kAsAsked, kBoth, kNone };

// Automatic exposure, automatic gain, or both off. 0.5 split the switch in two; up to 0.4 there is one.
inline ExposureTaken take_over_exposure(const libcamera::ControlInfoMap& known, [[maybe_unused]] bool exposure,
                                        [[maybe_unused]] bool gain, libcamera::ControlList& set) {
#if SRD_LIBCAMERA_AT_LEAST(0, 5)
  if (known.count(&libcamera::controls::ExposureTimeMode) != 0 && known.count(&libcamera::controls::AnalogueGainMode) != 0) {
    if (exposure) set.set(libcamera::controls::ExposureTimeMode, libcamera::controls::ExposureTimeModeManual);
    if (gain) set.set(libcamera::controls::AnalogueGainMode, libcamera::controls::AnalogueGainModeManual);
    return ExposureTaken::kAsAsked;
  }
#endif
  if (known.count(&libcamera::controls::AeEnable) == 0) return ExposureTaken::kNone;
  set.set(libcamera::controls::AeEnable, false);
  return ExposureTaken::kBoth;
}

}  // namespace srd
