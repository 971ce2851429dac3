// SPDX-License-Identifier: Apache-2.0
// What a calibration says of its lens's model, by the names that ROS, Kalibr, RealSense and OpenCV's samples use. Four
// numbers of a fisheye are read as k1 k2 p1 p2 without complaint, and every ray is then wrong.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace srd {

// Why the model is not the one that is computed here, OpenCV's polynomial lens; both empty: it is.
struct LensRefusal {
  std::string expected, found;
  [[nodiscard]] bool refused() const { return !found.empty(); }
};

// key: distortion_model, camera_model, model_type, or fisheye_model. name: its value as text. n: of distortion coefficients.
[[nodiscard]] LensRefusal check_lens_model(std::string_view key, std::string_view name, std::size_t n);

}  // namespace srd
