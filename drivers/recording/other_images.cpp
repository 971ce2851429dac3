// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/other_images.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>

namespace srd {

namespace {

struct Closer {
  void operator()(std::FILE* file) const noexcept { (void)std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Closer>;

// A JPEG decoder fills what is missing with grey and calls it done; the end marker tells a whole file from a
// cut one.
bool cut_jpeg(const std::string& file) {
  const File stream(std::fopen(file.c_str(), "rb"));
  std::array<unsigned char, 2> first{};
  if (!stream || std::fread(first.data(), 1, first.size(), stream.get()) != first.size()) return true;
  if (first[0] != 0xFF || first[1] != 0xD8) return false;
  std::array<unsigned char, 4096> tail{};
  if (std::fseek(stream.get(), 0, SEEK_END) != 0) return true;
  const long size = std::ftell(stream.get());
  const long start = std::max(0L, size - static_cast<long>(tail.size()));
  if (std::fseek(stream.get(), start, SEEK_SET) != 0) return true;
  std::size_t n = std::fread(tail.data(), 1, tail.size(), stream.get());
  while (n > 0 && tail[n - 1] == 0) --n;  // cameras pad with zeros
  return n < 2 || tail[n - 2] != 0xFF || tail[n - 1] != 0xD9;
}

}  // namespace

bool read_other_image(const std::string& file, GrayImage& image, int sample_bits) noexcept {
  try {
    if (cut_jpeg(file)) return false;
    const cv::Mat decoded = cv::imread(file, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
    if (decoded.type() != CV_8UC1 && decoded.type() != CV_16UC1) return false;
    image.width = decoded.cols;
    image.height = decoded.rows;
    image.pixels.resize(decoded.total());
    std::uint8_t* to = image.pixels.data();
    unsigned set = 0;
    image.sample_bits = decoded.type() == CV_8UC1 ? 8 : sample_bits == 0 ? 16 : sample_bits;
    const int shift = image.sample_bits - 8;
    for (int v = 0; v < decoded.rows; ++v, to += decoded.cols) {
      if (decoded.type() == CV_8UC1)
        std::memcpy(to, decoded.ptr(v), static_cast<std::size_t>(decoded.cols));
      else
        std::transform(decoded.ptr<std::uint16_t>(v), decoded.ptr<std::uint16_t>(v) + decoded.cols, to,
                       [&](std::uint16_t value) {
                         set |= value;
                         return static_cast<std::uint8_t>(std::min(255, value >> shift));
                       });
    }
    image.bits_set = static_cast<std::uint16_t>(set);
    return !image.pixels.empty();
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace srd
