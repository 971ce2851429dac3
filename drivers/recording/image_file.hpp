// SPDX-License-Identifier: Apache-2.0
// Grey images in files. PNG and PGM are read and written (both lossless); BMP, TIFF and JPEG are read by programs that
// link srd_other_images. Samples above 8 bits are shifted to 8, colour is turned to grey.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
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
  // Of the file: bits that its samples were taken to have (8 to 16), and all that are set in one of them or another (0 where
  // samples have 8 bits). What bits_at_lower_end() judges.
  int sample_bits = 8;
  std::uint16_t bits_set = 0;
  [[nodiscard]] GrayView view() const { return {pixels.data(), width, height, width}; }
};

// True for the endings of images: .png .pgm .bmp .tif .tiff .jpg .jpeg, in either case. Hidden files are none: what a system
// keeps beside images ("._1.png") has their ending and not their contents.
[[nodiscard]] bool is_image_name(const std::filesystem::path& file);

constexpr int kMinSampleBits = 8, kMaxSampleBits = 16;

// By contents, not by the ending. kInput for a missing, unreadable, cut or empty image. Samples of two bytes lose their low bits:
// of sample_bits (8 to 16), which lie at the lower end, the highest 8 stay, and what is above them is 255. sample_bits 0: 16, in
// a PGM with a maximum below 65535 those of the maximum. Files of one byte a sample are taken as they are.
[[nodiscard]] Outcome<GrayImage> read_gray_image(const std::filesystem::path& file, int sample_bits = 0);

// Samples of 8, 10, 12 or 14 bits that lie at the lower end of more, as cameras of so many bits are often saved, read as nearly
// black or dark: the fewest of these that hold all samples, where they are at least two fewer than were taken and the lowest
// bit is in use (of samples at the upper end it is not). Nothing: the samples use their range, or have 8 bits.
[[nodiscard]] std::optional<int> bits_at_lower_end(const GrayImage& image);
// The same in words, with what was taken; option: what sets it, "--bits". Empty: nothing to say.
[[nodiscard]] std::string bits_advice(const GrayImage& image, const std::string& option);

// A writable image of the caller's.
struct GrayBuffer {
  std::uint8_t* pixels = nullptr;
  int width = 0;
  int height = 0;
  int stride_bytes = 0;
};

// For frame loops: fills the buffer from an image of exactly its size. 8-bit PGM goes from the file straight
// into the buffer, without the heap. sample_bits: as above. false: unreadable, cut, or of another size.
[[nodiscard]] bool read_gray_image_into(const std::string& file, const GrayBuffer& buffer, int sample_bits = 0) noexcept;

// By the ending: .png (level 0 fastest to 9 smallest) or .pgm (8 bits, binary). Replaces the file.
[[nodiscard]] Outcome<void> write_gray_image(const std::filesystem::path& file, const GrayView& image, int png_level = 6);

}  // namespace srd
