// SPDX-License-Identifier: Apache-2.0
// What the size of a corner's residual means.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace srd::dsp {

enum class Metric : std::uint8_t {
  kReprojection = 0,  // px, raw image (11)
  kDisparity = 1,     // mm on the bottom plane (9)
  kCollinearity = 2,  // rad, difference of normals (10)
};
inline constexpr std::array<Metric, 3> kMetrics{Metric::kReprojection, Metric::kDisparity, Metric::kCollinearity};

// As configurations and coefficient files name it.
[[nodiscard]] constexpr const char* to_string(Metric metric) {
  switch (metric) {
    case Metric::kReprojection: return "reprojection";
    case Metric::kDisparity: return "disparity";
    case Metric::kCollinearity: return "collinearity";
  }
  return "unknown";
}

// Of a mean error.
[[nodiscard]] constexpr const char* unit(Metric metric) {
  switch (metric) {
    case Metric::kReprojection: return "px";
    case Metric::kDisparity: return "mm";
    case Metric::kCollinearity: return "rad";
  }
  return "";
}

[[nodiscard]] constexpr std::optional<Metric> parse_metric(std::string_view name) {
  for (const Metric metric : kMetrics)
    if (name == to_string(metric)) return metric;
  return std::nullopt;
}

}  // namespace srd::dsp
