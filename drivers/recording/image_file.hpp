// SPDX-License-Identifier: Apache-2.0
// Grey images in files. PNG and PGM are read and written (both lossless); BMP, TIFF and JPEG are read by programs that
// link srd_other_images. 16-bit images are shifted to 8 bits, colour is turned to grey.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/support/problem.hpp"
#include "dsp/core/image_view.hpp"

namespace srd {

// An image that owns its pixels, row by row without gaps.
struct GrayImage {
  std::vector<std::uint8_t> pixels;
  int width = 0;   // px
  int height = 0;  // px
  [[nodiscard]] GrayView view() const { return {pixels.data(), width, height, width}; }
};

// True for the endings of images: .png .pgm .bmp .tif .tiff .jpg .jpeg, in either case. Hidden files are none: what a system
// keeps beside images ("._1.png") has their ending and not their contents.
[[nodiscard]] bool is_image_name(const std::filesystem::path& file);

// By contents, not by the ending. kInput for a missing, unreadable, cut or empty image. 16-bit values lose their low bits: v >> 8, in a PGM
// with a maximum below 65535 as many bits as leave 8.
[[nodiscard]] Outcome<GrayImage> read_gray_image(const std::filesystem::path& file);

// A writable image of the caller's.
struct GrayBuffer {
  std::uint8_t* pixels = nullptr;
  int width = 0;
  int height = 0;
  int stride_bytes = 0;
};

// For frame loops: fills the buffer from an image of exactly its size. 8-bit PGM goes from the file straight
// into the buffer, without the heap. false: unreadable, cut, or of another size.
[[nodiscard]] bool read_gray_image_into(const std::string& file, const GrayBuffer& buffer) noexcept;

// By the ending: .png (level 0 fastest to 9 smallest) or .pgm (8 bits, binary). Replaces the file.
[[nodiscard]] Outcome<void> write_gray_image(const std::filesystem::path& file, const GrayView& image, int png_level = 6);

}  // namespace srd
