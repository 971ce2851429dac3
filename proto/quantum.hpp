// SPDX-License-Identifier: Apache-2.0
// A corner's coordinate in steps of 1/1024 px (3e-4 px rms of rounding).
#pragma once

#include <cmath>
#include <cstdint>

namespace srd::proto {

inline constexpr float kQuantaPerPixel = 1024;
inline constexpr std::int32_t kMostQuanta = 65536 * 1024;

[[nodiscard]] inline std::int32_t to_quanta(float pixels) {
  return static_cast<std::int32_t>(std::lround(pixels * kQuantaPerPixel));
}
[[nodiscard]] inline float from_quanta(std::int32_t quanta) { return static_cast<float>(quanta) / kQuantaPerPixel; }

}  // namespace srd::proto
