// SPDX-License-Identifier: Apache-2.0
// The pixel formats that the V4L2 driver takes, and how their brightness lies in memory. Pure; any thread.
#pragma once

#include <linux/videodev2.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/camera/gray_conversion.hpp"

namespace srd {

struct V4l2PixelFormat {
  std::string_view name;  // as the configuration says it
  std::uint32_t code;     // V4L2_PIX_FMT_*
  GrayLayout layout;
  int bits;  // that a pixel of two bytes uses
  [[nodiscard]] constexpr bool zero_copy() const { return layout == GrayLayout::kBytes; }
};

// In the order that "auto" prefers: no conversion and least to move first. NM12 is NV12 with its planes apart.
inline constexpr std::array kV4l2Formats{
    V4l2PixelFormat{"GREY", V4L2_PIX_FMT_GREY, GrayLayout::kBytes, 8},
    V4l2PixelFormat{"Y10", V4L2_PIX_FMT_Y10, GrayLayout::kLittleEndian, 10},
    V4l2PixelFormat{"Y12", V4L2_PIX_FMT_Y12, GrayLayout::kLittleEndian, 12},
    V4l2PixelFormat{"Y16", V4L2_PIX_FMT_Y16, GrayLayout::kLittleEndian, 16},
    V4l2PixelFormat{"YUYV", V4L2_PIX_FMT_YUYV, GrayLayout::kEvenBytes, 8},
    V4l2PixelFormat{"NV12", V4L2_PIX_FMT_NV12, GrayLayout::kBytes, 8},
    V4l2PixelFormat{"NV12", V4L2_PIX_FMT_NV12M, GrayLayout::kBytes, 8},
};

[[nodiscard]] const V4l2PixelFormat* v4l2_format_of(std::uint32_t code);
// "auto, GREY, Y10, ...": what the configuration's key takes.
[[nodiscard]] std::string v4l2_format_names();
[[nodiscard]] bool is_v4l2_format_name(std::string_view name);
// Four characters, without blanks at the end; others than letters and digits as '.'.
[[nodiscard]] std::string fourcc_text(std::uint32_t code);

}  // namespace srd
