// SPDX-License-Identifier: Apache-2.0
// What a capture device says that it can do: formats, sizes, rates. At start and for listings, not in the loop.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/camera/v4l2/v4l2_port.hpp"

namespace srd {

// Frame rates, Hz: single ones, or all between the first and the last.
struct V4l2Rates {
  std::vector<double> hz;
  bool range = false;
};

// One size, or all from least to most in steps.
struct V4l2Size {
  int width = 0, height = 0;  // px; the largest of a range
  int least_width = 0, least_height = 0;
  int step_width = 0, step_height = 0;  // 0: one size
  V4l2Rates rates;                      // at width x height; empty: the device does not say
};

struct V4l2Offer {
  std::uint32_t code = 0;
  std::string description;
  bool compressed = false;
  std::vector<V4l2Size> sizes;  // empty: the device does not say
};

struct V4l2Identity {
  std::string card, driver, bus;
  std::uint32_t capabilities = 0;  // of this node
  [[nodiscard]] bool captures() const;
  [[nodiscard]] bool multi_planar() const;  // and not single-planar
  [[nodiscard]] bool streams() const;
  // "a video capture device", "a video output", "a metadata node" ..
  [[nodiscard]] std::string kind() const;
};

// 0 or errno: ENOTTY for what is no video device.
[[nodiscard]] int identify(V4l2Port& port, V4l2Identity& identity);
[[nodiscard]] std::vector<V4l2Offer> offers_of(V4l2Port& port, std::uint32_t buffer_type);
[[nodiscard]] V4l2Rates rates_of(V4l2Port& port, std::uint32_t code, int width, int height);

// "30, 60 Hz", "1 to 60 Hz", "" when not known.
[[nodiscard]] std::string rates_text(const V4l2Rates& rates);
// One line a format that the driver takes, the others in one more: "GREY 640x480 (30, 60 Hz), 320x240 (120 Hz)".
// margin: before each line. fallback: said of formats without sizes, such as "1280x720".
[[nodiscard]] std::string offers_text(const std::vector<V4l2Offer>& offers, const std::string& margin,
                                      const std::string& fallback);

}  // namespace srd
