// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/pgm_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "drivers/support/limits.hpp"

namespace srd {

namespace {

// A file read through a small buffer of its own: stdio takes one from the heap for every file.
class FileReader {
 public:
  explicit FileReader(const char* name) : descriptor_(::open(name, O_RDONLY | O_CLOEXEC)) {}
  ~FileReader() {
    if (descriptor_ >= 0) (void)::close(descriptor_);
  }
  FileReader(const FileReader&) = delete;
  FileReader& operator=(const FileReader&) = delete;

  // The next byte, or -1 at the end.
  int get() {
    if (at_ == filled_ && !fill()) return -1;
    return buffer_[at_++];
  }
  // All of n bytes, or false.
  bool read(unsigned char* to, std::size_t n) {
    const std::size_t held = std::min(n, filled_ - at_);
    std::memcpy(to, buffer_.data() + at_, held);
    at_ += held;
    for (std::size_t done = held; done < n;) {
      const ssize_t got = some(to + done, n - done);
      if (got <= 0) return false;
      done += static_cast<std::size_t>(got);
    }
    return true;
  }

 private:
  bool fill() {
    const ssize_t got = some(buffer_.data(), buffer_.size());
    at_ = 0;
    filled_ = got > 0 ? static_cast<std::size_t>(got) : 0;
    return filled_ > 0;
  }
  ssize_t some(unsigned char* to, std::size_t n) const {
    ssize_t got = -1;
    do got = ::read(descriptor_, to, n);
    while (got < 0 && errno == EINTR);
    return got;
  }

  int descriptor_;
  std::array<unsigned char, 256> buffer_;
  std::size_t at_ = 0, filled_ = 0;
};

struct PgmHeader {
  int width = 0, height = 0, maximum = 0;
};

// One number of a PGM header and the single blank after it; comments run from '#' to the line's end. -1:
// none.
int header_number(FileReader& file) {
  int c = file.get();
  while (c == '#' || (c >= 0 && std::isspace(c) != 0)) {
    if (c == '#')
      while (c != '\n' && c >= 0) c = file.get();
    else
      c = file.get();
  }
  int number = -1;
  for (; c >= '0' && c <= '9'; c = file.get()) {
    number = std::max(number, 0) * 10 + (c - '0');
    if (number > kMaxSide) return -1;
  }
  return c >= 0 && std::isspace(c) != 0 ? number : -1;
}

bool pgm_header(FileReader& file, PgmHeader& header) {
  if (file.get() != 'P' || file.get() != '5') return false;
  header.width = header_number(file);
  header.height = header_number(file);
  header.maximum = header_number(file);
  return header.width > 0 && header.height > 0 && header.maximum > 0;
}

bool pgm_pixels(FileReader& file, const PgmHeader& header, const GrayBuffer& to, PgmSamples& samples) {
  const auto width = static_cast<std::size_t>(header.width);
  if (header.maximum < 256)
    samples.bits = 8;
  else if (samples.bits == 0)
    samples.bits = std::bit_width(static_cast<unsigned>(header.maximum));
  const int shift = samples.bits - 8;
  unsigned set = 0;
  std::array<unsigned char, 4096> chunk;
  for (int v = 0; v < header.height; ++v) {
    std::uint8_t* row = to.pixels + static_cast<std::int64_t>(v) * to.stride_bytes;
    if (header.maximum < 256) {
      if (!file.read(row, width)) return false;
      continue;
    }
    for (std::size_t u = 0; u < width;) {
      const std::size_t n = std::min(width - u, chunk.size() / 2);
      if (!file.read(chunk.data(), 2 * n)) return false;
      for (std::size_t i = 0; i < n; ++i, ++u) {
        const unsigned sample = static_cast<unsigned>(chunk[2 * i]) << 8 | chunk[2 * i + 1];
        set |= sample;
        row[u] = static_cast<std::uint8_t>(std::min(255U, sample >> shift));
      }
    }
  }
  samples.set = static_cast<std::uint16_t>(set);
  return true;
}

}  // namespace

std::optional<PgmSize> pgm_size(const std::string& file) noexcept {
  FileReader reader(file.c_str());
  PgmHeader header;
  if (!pgm_header(reader, header)) return std::nullopt;
  const std::size_t depth = header.maximum > 255 ? 2 : 1;
  return PgmSize{header.width, header.height,
                 static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height) * depth};
}

bool read_pgm(const std::string& file, const GrayBuffer& to, PgmSamples& samples) noexcept {
  FileReader reader(file.c_str());
  PgmHeader header;
  return pgm_header(reader, header) && header.width == to.width && header.height == to.height &&
         pgm_pixels(reader, header, to, samples);
}

bool write_pgm(const std::string& file, const GrayView& image) {
  std::FILE* stream = std::fopen(file.c_str(), "wb");
  if (stream == nullptr) return false;
  bool good = std::fprintf(stream, "P5\n%d %d\n255\n", image.width, image.height) > 0;
  const auto width = static_cast<std::size_t>(image.width);
  for (int v = 0; good && v < image.height; ++v) good = std::fwrite(image.row(v), 1, width, stream) == width;
  const int why = errno;
  if (std::fclose(stream) == 0)
    errno = why;
  else
    good = false;
  return good;
}

}  // namespace srd
