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
  Mosaic mosaic = Mosaic::kNone;
  [[nodiscard]] constexpr bool zero_copy() const { return layout == GrayLayout::kBytes && mosaic == Mosaic::kNone; }
  [[nodiscard]] constexpr bool compressed() const { return layout == GrayLayout::kJpeg; }
  // Pixels of the device along one of the image's.
  [[nodiscard]] constexpr int reduction() const { return mosaic == Mosaic::kNone ? 1 : 2; }
};

// In the order that "auto" prefers: no conversion and least to move first, then what loses detail, then what halves the image.
// NM12 is NV12 with its planes apart.
inline constexpr std::array kV4l2Formats{
    V4l2PixelFormat{"GREY", V4L2_PIX_FMT_GREY, GrayLayout::kBytes, 8},
    V4l2PixelFormat{"Y10", V4L2_PIX_FMT_Y10, GrayLayout::kLittleEndian, 10},
    V4l2PixelFormat{"Y12", V4L2_PIX_FMT_Y12, GrayLayout::kLittleEndian, 12},
    V4l2PixelFormat{"Y16", V4L2_PIX_FMT_Y16, GrayLayout::kLittleEndian, 16},
    V4l2PixelFormat{"Y10P", V4L2_PIX_FMT_Y10P, GrayLayout::kPackedTen, 10},
    V4l2PixelFormat{"YUYV", V4L2_PIX_FMT_YUYV, GrayLayout::kEvenBytes, 8},
    V4l2PixelFormat{"NV12", V4L2_PIX_FMT_NV12, GrayLayout::kBytes, 8},
    V4l2PixelFormat{"NV12", V4L2_PIX_FMT_NV12M, GrayLayout::kBytes, 8},
    V4l2PixelFormat{"MJPG", V4L2_PIX_FMT_MJPEG, GrayLayout::kJpeg, 8},
    V4l2PixelFormat{"MJPG", V4L2_PIX_FMT_JPEG, GrayLayout::kJpeg, 8},
    V4l2PixelFormat{"SBGGR8", V4L2_PIX_FMT_SBGGR8, GrayLayout::kBytes, 8, Mosaic::kGreenAside},
    V4l2PixelFormat{"SGBRG8", V4L2_PIX_FMT_SGBRG8, GrayLayout::kBytes, 8, Mosaic::kGreenFirst},
    V4l2PixelFormat{"SGRBG8", V4L2_PIX_FMT_SGRBG8, GrayLayout::kBytes, 8, Mosaic::kGreenFirst},
    V4l2PixelFormat{"SRGGB8", V4L2_PIX_FMT_SRGGB8, GrayLayout::kBytes, 8, Mosaic::kGreenAside},
    V4l2PixelFormat{"SBGGR10", V4L2_PIX_FMT_SBGGR10, GrayLayout::kLittleEndian, 10, Mosaic::kGreenAside},
    V4l2PixelFormat{"SGBRG10", V4L2_PIX_FMT_SGBRG10, GrayLayout::kLittleEndian, 10, Mosaic::kGreenFirst},
    V4l2PixelFormat{"SGRBG10", V4L2_PIX_FMT_SGRBG10, GrayLayout::kLittleEndian, 10, Mosaic::kGreenFirst},
    V4l2PixelFormat{"SRGGB10", V4L2_PIX_FMT_SRGGB10, GrayLayout::kLittleEndian, 10, Mosaic::kGreenAside},
    V4l2PixelFormat{"SBGGR10P", V4L2_PIX_FMT_SBGGR10P, GrayLayout::kPackedTen, 10, Mosaic::kGreenAside},
    V4l2PixelFormat{"SGBRG10P", V4L2_PIX_FMT_SGBRG10P, GrayLayout::kPackedTen, 10, Mosaic::kGreenFirst},
    V4l2PixelFormat{"SGRBG10P", V4L2_PIX_FMT_SGRBG10P, GrayLayout::kPackedTen, 10, Mosaic::kGreenFirst},
    V4l2PixelFormat{"SRGGB10P", V4L2_PIX_FMT_SRGGB10P, GrayLayout::kPackedTen, 10, Mosaic::kGreenAside},
};

[[nodiscard]] const V4l2PixelFormat* v4l2_format_of(std::uint32_t code);
// "auto, GREY, Y10, ...": what the configuration's key takes.
[[nodiscard]] std::string v4l2_format_names();
[[nodiscard]] bool is_v4l2_format_name(std::string_view name);
// Four characters, without blanks at the end; others than letters and digits as '.'.
[[nodiscard]] std::string fourcc_text(std::uint32_t code);

}  // namespace srd
