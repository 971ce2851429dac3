// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/image_file.hpp"

#include <algorithm>
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
bool decode(const std::string& file, GrayImage& image) noexcept {
  if (is_png(file)) return read_png(file, image);
  return reads_others() && read_other_image(file, image);
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

Outcome<GrayImage> read_gray_image(const fs::path& file) {
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
    if (read_pgm(file.string(), {image.pixels.data(), image.width, image.height, image.width})) return image;
    return unreadable(file, "a file that ends too early");
  }
  if (!decode(file.string(), image)) return unreadable(file, "other contents, or a file that ends too early");
  return image;
}

bool read_gray_image_into(const std::string& file, const GrayBuffer& buffer) noexcept {
  if (read_pgm(file, buffer)) return true;
  if (pgm_size(file)) return false;
  GrayImage image;
  if (!decode(file, image) || image.width != buffer.width || image.height != buffer.height) return false;
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
