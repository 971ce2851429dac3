// SPDX-License-Identifier: Apache-2.0
// The pixel formats that the libcamera driver takes, and how their brightness lies in memory.
#pragma once

#include <libcamera/formats.h>
#include <libcamera/pixel_format.h>

#include <array>

#include "drivers/camera/gray_conversion.hpp"

namespace srd {

struct LibcameraFormat {
  libcamera::PixelFormat format;
  GrayLayout layout;
  int bits;
  [[nodiscard]] bool zero_copy() const { return layout == GrayLayout::kBytes; }
};

// In the order of preference within one stream: libcamera_choice.hpp. libcamera names colours from the high byte down, memory holds them from the low byte up.
inline const std::array<LibcameraFormat, 9> kLibcameraFormats{{
    {libcamera::formats::R8, GrayLayout::kBytes, 8},
    {libcamera::formats::YUV420, GrayLayout::kBytes, 8},
    {libcamera::formats::NV12, GrayLayout::kBytes, 8},
    {libcamera::formats::R10, GrayLayout::kLittleEndian, 10},
    {libcamera::formats::R12, GrayLayout::kLittleEndian, 12},
    {libcamera::PixelFormat::fromString("R16"), GrayLayout::kLittleEndian, 16},
    {libcamera::formats::YUYV, GrayLayout::kEvenBytes, 8},
    {libcamera::formats::BGR888, GrayLayout::kRgb, 8},
    {libcamera::formats::RGB888, GrayLayout::kBgr, 8},
}};

}  // namespace srd
