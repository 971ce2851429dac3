// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/png_file.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <memory>
#include <new>

#include "drivers/support/limits.hpp"

namespace srd {

namespace {

constexpr std::size_t kSignatureBytes = 8;

struct Closer {
  void operator()(std::FILE* file) const noexcept { (void)std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Closer>;

// libpng prints by itself otherwise; what is wrong is said by whoever asked for the image.
void end_reading(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void keep_quiet(png_structp, png_const_charp) {}

// Samples of two bytes, the high one first, to one byte each in the same place.
void keep_high_bits(GrayImage& image) {
  const std::size_t n = image.pixels.size() / 2;
  const int shift = image.sample_bits - 8;
  unsigned set = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const unsigned sample = static_cast<unsigned>(image.pixels[2 * i]) << 8 | image.pixels[2 * i + 1];
    set |= sample;
    image.pixels[i] = static_cast<std::uint8_t>(std::min(255U, sample >> shift));
  }
  image.pixels.resize(n);
  image.bits_set = static_cast<std::uint16_t>(set);
}

// libpng leaves by longjmp: the functions that call setjmp own nothing that a destructor would have to free.
bool read_rows(png_structp png, png_infop info, std::FILE* file, GrayImage& image, int sample_bits) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT: libpng's way
  png_init_io(png, file);
  png_set_user_limits(png, kMaxSide, kMaxSide);
  png_read_info(png, info);
  const png_byte colour = png_get_color_type(png, info);
  png_set_expand(png);
  png_set_strip_alpha(png);
  if ((colour & PNG_COLOR_MASK_COLOR) != 0) png_set_rgb_to_gray(png, PNG_ERROR_ACTION_NONE, 0.299, 0.587);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  image.width = static_cast<int>(png_get_image_width(png, info));
  image.height = static_cast<int>(png_get_image_height(png, info));
  const std::size_t bytes = png_get_bit_depth(png, info) == 16 ? 2 : 1, row = static_cast<std::size_t>(image.width) * bytes;
  if (png_get_rowbytes(png, info) != row) return false;
  try {
    image.pixels.resize(row * static_cast<std::size_t>(image.height));
  } catch (const std::bad_alloc&) {
    return false;
  }
  for (int pass = 0; pass < passes; ++pass)
    for (int v = 0; v < image.height; ++v) png_read_row(png, image.pixels.data() + static_cast<std::size_t>(v) * row, nullptr);
  png_read_end(png, nullptr);
  image.sample_bits = bytes == 1 ? 8 : sample_bits == 0 ? 16 : sample_bits;
  if (bytes == 2) keep_high_bits(image);
  return true;
}

bool write_rows(png_structp png, png_infop info, std::FILE* file, const GrayView& image, int level) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT: libpng's way
  png_init_io(png, file);
  png_set_compression_level(png, level);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 8, PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int v = 0; v < image.height; ++v) png_write_row(png, image.row(v));
  png_write_end(png, nullptr);
  return true;
}

}  // namespace

bool is_png(const std::string& file) noexcept {
  const File stream(std::fopen(file.c_str(), "rb"));
  std::array<png_byte, kSignatureBytes> first{};
  return stream && std::fread(first.data(), 1, first.size(), stream.get()) == first.size() &&
         png_sig_cmp(first.data(), 0, first.size()) == 0;
}

bool read_png(const std::string& file, GrayImage& image, int sample_bits) noexcept {
  const File stream(std::fopen(file.c_str(), "rb"));
  if (!stream) return false;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, end_reading, keep_quiet);
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  const bool good = info != nullptr && read_rows(png, info, stream.get(), image, sample_bits);
  png_destroy_read_struct(&png, &info, nullptr);
  return good;
}

bool write_png(const std::string& file, const GrayView& image, int level) noexcept {
  File stream(std::fopen(file.c_str(), "wb"));
  if (!stream) return false;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, end_reading, keep_quiet);
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  const bool good = info != nullptr && write_rows(png, info, stream.get(), image, level);
  png_destroy_write_struct(&png, &info);
  return std::fclose(stream.release()) == 0 && good;
}

}  // namespace srd
