// SPDX-License-Identifier: Apache-2.0
// Whole images to 8-bit grey: integers only, the high bits kept, nothing rounded. Pure; any thread.
//
// A colour sensor's raw image is a mosaic (Bayer): its grey is made of cells of 2 x 2 pixels and has half of its size each way.
// Everything behind it, the calibration too, is in the pixels of that half image. The centre of the top left pixel is (0, 0) in
// both, and a cell is where its middle is: u_half = (u - 0.5) / 2, v_half = (v - 0.5) / 2.
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
  kBgr,        // three bytes a pixel: (77 R + 150 G + 29 B) / 256, which keeps grey as it is
  kPackedTen,  // four pixels of 10 bits in five bytes (CSI-2's RAW10): their high 8 bits each, then the low ones of all four
  kJpeg,       // one JPEG a frame, which has no rows: gray_jpeg.hpp
};

// That a row of pixels takes; 0 for kJpeg.
[[nodiscard]] constexpr int row_bytes(GrayLayout layout, int width) {
  switch (layout) {
    case GrayLayout::kBytes: return width;
    case GrayLayout::kEvenBytes:
    case GrayLayout::kLittleEndian: return 2 * width;
    case GrayLayout::kRgb:
    case GrayLayout::kBgr: return 3 * width;
    case GrayLayout::kPackedTen:
      return (width + 3) / 4 * 5;  // whole groups: the low bits of the last pixels are in its last byte
    case GrayLayout::kJpeg: break;
  }
  return 0;
}

// Where the green pixels of a mosaic's cell are.
enum class Mosaic : std::uint8_t {
  kNone,
  kGreenAside,  // right and below: RGGB, BGGR
  kGreenFirst,  // top left and bottom right: GRBG, GBRG
};

// What a cell's grey is the mean of.
enum class MosaicGray : std::uint8_t {
  kGreen,  // the two green pixels: their middle is the cell's whatever colour the light has
  kAll,    // all four, for light with little green. Where one colour is brighter than another, the image is off by its
           // middle's offset, below a quarter of a pixel: the calibration takes that up when it is made in the same light
};

// No kJpeg. width x height pixels from `from` (rows from_stride bytes apart) into `to`. bits: that a pixel of kLittleEndian uses,
// 8 to 16, in the low end of its two bytes; the result is its highest eight. The images do not overlap.
void convert_to_gray(GrayLayout layout, int bits, const std::uint8_t* from, int from_stride, std::uint8_t* to, int to_stride,
                     int width, int height) noexcept;

// The same of a mosaic: width x height is of the result, half of the mosaic's. layout: kBytes, kLittleEndian or kPackedTen.
void halve_mosaic(GrayLayout layout, int bits, Mosaic mosaic, MosaicGray gray, const std::uint8_t* from, int from_stride,
                  std::uint8_t* to, int to_stride, int width, int height) noexcept;

}  // namespace srd
