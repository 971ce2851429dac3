#include "drivers/recording/image_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <opencv2/imgcodecs.hpp>

#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

namespace fs = std::filesystem;

constexpr int kMostSide = 65535;  // px
constexpr std::size_t kPngLevelMost = 9;

struct Closer {
  void operator()(std::FILE* file) const noexcept { (void)std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Closer>;

bool ends_in(const std::string& name, std::string_view ending) {
  if (name.size() < ending.size()) return false;
  return std::equal(
      ending.begin(), ending.end(), name.end() - static_cast<std::ptrdiff_t>(ending.size()),
      [](char a, char b) { return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b))); });
}

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
    if (number > kMostSide) return -1;
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

bool pgm_pixels(FileReader& file, const PgmHeader& header, const GrayBuffer& to) {
  const auto width = static_cast<std::size_t>(header.width);
  const int shift = std::max(0, static_cast<int>(std::bit_width(static_cast<unsigned>(header.maximum))) - 8);
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
      for (std::size_t i = 0; i < n; ++i, ++u)
        row[u] = static_cast<std::uint8_t>(std::min(255, ((chunk[2 * i] << 8) | chunk[2 * i + 1]) >> shift));
    }
  }
  return true;
}

// A JPEG decoder fills what is missing with grey and calls it done; the end marker tells a whole file from a
// cut one.
bool cut_jpeg(const std::string& file) {
  if (!ends_in(file, ".jpg") && !ends_in(file, ".jpeg")) return false;
  const File stream(std::fopen(file.c_str(), "rb"));
  if (!stream) return true;
  std::array<unsigned char, 4096> tail{};
  if (std::fseek(stream.get(), 0, SEEK_END) != 0) return true;
  const long size = std::ftell(stream.get());
  const long start = std::max(0L, size - static_cast<long>(tail.size()));
  if (std::fseek(stream.get(), start, SEEK_SET) != 0) return true;
  std::size_t n = std::fread(tail.data(), 1, tail.size(), stream.get());
  while (n > 0 && tail[n - 1] == 0) --n;  // cameras pad with zeros
  return n < 2 || tail[n - 2] != 0xFF || tail[n - 1] != 0xD9;
}

// 8-bit grey by OpenCV; empty when it cannot.
cv::Mat decode(const std::string& file) noexcept {
  try {
    if (cut_jpeg(file)) return {};
    cv::Mat image =
        cv::imread(file, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
    if (image.type() == CV_16UC1) {
      cv::Mat shifted(image.rows, image.cols, CV_8UC1);
      for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u)
          shifted.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(image.at<std::uint16_t>(v, u) >> 8);
      return shifted;
    }
    return image.type() == CV_8UC1 ? image : cv::Mat();
  } catch (const std::exception&) {
    return {};
  }
}

void copy_rows(const cv::Mat& from, const GrayBuffer& to) {
  for (int v = 0; v < from.rows; ++v)
    std::memcpy(to.pixels + static_cast<std::int64_t>(v) * to.stride_bytes, from.ptr(v),
                static_cast<std::size_t>(from.cols));
}

Problem unreadable(const fs::path& file, const std::string& found) {
  return {Exit::kInput,  "is not a readable image",
          file.string(), "a whole grey image (PNG, PGM, BMP, TIFF or JPEG) of 8 or 16 bits",
          found,         ""};
}

Problem unwritable(const fs::path& file, const std::string& found) {
  return {Exit::kInput,  "cannot be written",
          file.string(), "a writable folder with room",
          found,         "check the folder, its permissions and the disk"};
}

Outcome<void> write_pgm(const fs::path& file, const GrayView& image) {
  File stream(std::fopen(file.c_str(), "wb"));
  if (!stream) return unwritable(file, std::strerror(errno));
  bool good = std::fprintf(stream.get(), "P5\n%d %d\n255\n", image.width, image.height) > 0;
  const auto width = static_cast<std::size_t>(image.width);
  for (int v = 0; good && v < image.height; ++v)
    good = std::fwrite(image.row(v), 1, width, stream.get()) == width;
  if (std::fclose(stream.release()) != 0 || !good) return unwritable(file, std::strerror(errno));
  return {};
}

}  // namespace

bool is_image_name(const fs::path& file) {
  const std::string name = file.filename().string();
  for (const std::string_view ending : {".png", ".pgm", ".bmp", ".tif", ".tiff", ".jpg", ".jpeg"})
    if (ends_in(name, ending)) return true;
  return false;
}

Outcome<GrayImage> read_gray_image(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return unreadable(file, "no such file");
  if (!fs::is_regular_file(file, error)) return unreadable(file, "a folder or device");
  if (fs::file_size(file, error) == 0) return unreadable(file, "an empty file");
  GrayImage image;
  if (ends_in(file.string(), ".pgm")) {
    FileReader reader(file.c_str());
    PgmHeader header;
    if (pgm_header(reader, header)) {
      // Compared before anything is reserved: a header can claim any size.
      const std::uintmax_t bytes =
          static_cast<std::uintmax_t>(header.width) * header.height * (header.maximum > 255 ? 2U : 1U);
      if (fs::file_size(file, error) < bytes || error) return unreadable(file, "a file that ends too early");
      image.width = header.width;
      image.height = header.height;
      image.pixels.resize(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height));
      if (pgm_pixels(reader, header, {image.pixels.data(), header.width, header.height, header.width}))
        return image;
      return unreadable(file, "a file that ends too early");
    }
  }
  const cv::Mat decoded = decode(file.string());
  if (decoded.empty()) return unreadable(file, "other contents, or a file that ends too early");
  image.width = decoded.cols;
  image.height = decoded.rows;
  image.pixels.resize(decoded.total());
  copy_rows(decoded, {image.pixels.data(), image.width, image.height, image.width});
  return image;
}

bool read_gray_image_into(const std::string& file, const GrayBuffer& buffer) noexcept {
  if (ends_in(file, ".pgm")) {
    FileReader reader(file.c_str());
    PgmHeader header;
    if (pgm_header(reader, header))
      return header.width == buffer.width && header.height == buffer.height &&
             pgm_pixels(reader, header, buffer);
  }
  const cv::Mat decoded = decode(file);
  if (decoded.empty() || decoded.cols != buffer.width || decoded.rows != buffer.height) return false;
  copy_rows(decoded, buffer);
  return true;
}

Outcome<void> write_gray_image(const fs::path& file, const GrayView& image, int png_level) {
  if (ends_in(file.string(), ".pgm")) return write_pgm(file, image);
  try {
    // OpenCV only reads from it; its type has no const.
    const cv::Mat mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels),
                      static_cast<std::size_t>(image.stride_bytes));
    std::vector<std::uint8_t> bytes;
    const int level = std::clamp(png_level, 0, static_cast<int>(kPngLevelMost));
    if (!cv::imencode(".png", mat, bytes, {cv::IMWRITE_PNG_COMPRESSION, level}))
      return unwritable(file, "OpenCV cannot encode PNG");
    return write_text_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } catch (const std::exception& exception) {
    return unwritable(file, exception.what());
  }
}

}  // namespace srd
