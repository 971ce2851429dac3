// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/image_file.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstring>

#include "drivers/recording/other_images.hpp"
#include "drivers/recording/pgm_file.hpp"
#include "drivers/recording/png_file.hpp"

namespace srd {

namespace {

namespace fs = std::filesystem;

constexpr int kPngLevelMost = 9;

bool ends_in(const std::string& name, std::string_view ending) {
  if (name.size() < ending.size()) return false;
  return std::equal(ending.begin(), ending.end(), name.end() - static_cast<std::ptrdiff_t>(ending.size()),
                    [](char a, char b) { return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b))); });
}

bool reads_others() { return &read_other_image != nullptr; }

// All but PGM, by contents.
bool decode(const std::string& file, GrayImage& image, int sample_bits) noexcept {
  if (is_png(file)) return read_png(file, image, sample_bits);
  return reads_others() && read_other_image(file, image, sample_bits);
}

Problem unreadable(const fs::path& file, const std::string& found) {
  Problem problem{Exit::kInput, "is not a readable image", file.string(), "", found, ""};
  problem.expected = reads_others() ? "a whole grey image (PNG, PGM, BMP, TIFF or JPEG) of 8 or 16 bits"
                                    : "a whole grey image (PNG or PGM; srd reads more kinds) of 8 or 16 bits";
  return problem;
}

}  // namespace

bool is_image_name(const fs::path& file) {
  const std::string name = file.filename().string();
  if (name.starts_with('.')) return false;
  for (const std::string_view ending : {".png", ".pgm", ".bmp", ".tif", ".tiff", ".jpg", ".jpeg"})
    if (ends_in(name, ending)) return true;
  return false;
}

std::optional<int> bits_at_lower_end(const GrayImage& image) {
  if ((image.bits_set & 1) == 0) return std::nullopt;
  const int used = std::bit_width(static_cast<unsigned>(image.bits_set));
  for (const int bits : {8, 10, 12, 14})
    if (used <= bits && bits <= image.sample_bits - 2) return bits;
  return std::nullopt;
}

std::string bits_advice(const GrayImage& image, const std::string& option) {
  const auto bits = bits_at_lower_end(image);
  if (!bits) return {};
  return "no sample needs more than " + std::to_string(std::bit_width(static_cast<unsigned>(image.bits_set))) + " of the " +
         std::to_string(image.sample_bits) + " bits that they were taken to have: if the camera has " + std::to_string(*bits) +
         " bits, " + option + (option.starts_with("--") ? " " : " = ") + std::to_string(*bits) + " reads them so";
}

Outcome<GrayImage> read_gray_image(const fs::path& file, int sample_bits) {
  std::error_code error;
  if (!fs::exists(file, error)) return unreadable(file, "no such file");
  if (!fs::is_regular_file(file, error)) return unreadable(file, "a folder or device");
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (bytes == 0) return unreadable(file, "an empty file");
  GrayImage image;
  if (const auto size = pgm_size(file.string())) {
    // Compared before anything is reserved: a header can claim any size.
    if (error || bytes < size->bytes) return unreadable(file, "a file that ends too early");
    image.width = size->width;
    image.height = size->height;
    image.pixels.resize(static_cast<std::size_t>(size->width) * static_cast<std::size_t>(size->height));
    PgmSamples samples{sample_bits, 0};
    if (read_pgm(file.string(), {image.pixels.data(), image.width, image.height, image.width}, samples)) {
      image.sample_bits = samples.bits;
      image.bits_set = samples.set;
      return image;
    }
    return unreadable(file, "a file that ends too early");
  }
  if (!decode(file.string(), image, sample_bits)) return unreadable(file, "other contents, or a file that ends too early");
  return image;
}

bool read_gray_image_into(const std::string& file, const GrayBuffer& buffer, int sample_bits) noexcept {
  PgmSamples samples{sample_bits, 0};
  if (read_pgm(file, buffer, samples)) return true;
  if (pgm_size(file)) return false;
  GrayImage image;
  if (!decode(file, image, sample_bits) || image.width != buffer.width || image.height != buffer.height) return false;
  const GrayView view = image.view();
  for (int v = 0; v < view.height; ++v)
    std::memcpy(buffer.pixels + static_cast<std::int64_t>(v) * buffer.stride_bytes, view.row(v),
                static_cast<std::size_t>(view.width));
  return true;
}

Outcome<void> write_gray_image(const fs::path& file, const GrayView& image, int png_level) {
  errno = 0;
  const bool good = ends_in(file.string(), ".pgm") ? write_pgm(file.string(), image)
                                                   : write_png(file.string(), image, std::clamp(png_level, 0, kPngLevelMost));
  if (good) return {};
  return Problem{Exit::kInput,
                 "cannot be written",
                 file.string(),
                 "a writable folder with room",
                 errno != 0 ? std::strerror(errno) : "an image that cannot be encoded",
                 "check the folder, its permissions and the disk"};
}

}  // namespace srd
