// SPDX-License-Identifier: Apache-2.0
// Whole images to 8-bit grey: integers only, the high bits kept, nothing rounded. Pure; any thread.
#pragma once

#include <cstddef>
#include <cstdint>

namespace srd {

// How a source's brightness lies in memory.
enum class GrayLayout : std::uint8_t {
  kBytes,         // a byte a pixel, also the first plane of NV12 and YUV420: needs no conversion
  kEvenBytes,     // every second byte from the first one: YUYV
  kLittleEndian,  // two bytes a pixel, the low one first: 10, 12 and 16 bits
  kRgb,
  kBgr,  // three bytes a pixel: (77 R + 150 G + 29 B) / 256, which keeps grey as it is
};

[[nodiscard]] constexpr int bytes_per_pixel(GrayLayout layout) {
  return layout == GrayLayout::kBytes ? 1 : layout == GrayLayout::kRgb || layout == GrayLayout::kBgr ? 3 : 2;
}

// width x height pixels from `from` (rows from_stride bytes apart) into `to`. bits: that a pixel of kLittleEndian uses,
// 8 to 16, in the low end of its two bytes; the result is its highest eight. The images do not overlap.
void convert_to_gray(GrayLayout layout, int bits, const std::uint8_t* from, int from_stride, std::uint8_t* to, int to_stride,
                     int width, int height) noexcept;

}  // namespace srd
