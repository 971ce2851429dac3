// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

// After <cstdio>, which it wants.
#include <jpeglib.h>

#include "drivers/camera/gray_jpeg.hpp"
#include "dsp/frontend/board_finder.hpp"
#include "tests/fakes/allocation_gauge.hpp"
#include "tests/fakes/jpeg_image.hpp"

namespace srd {
namespace {

struct FilmedPicture {
  int width, height;
  std::vector<std::uint8_t> pixels;
  [[nodiscard]] GrayView view() const { return {pixels.data(), width, height, width}; }
};

// Where a board's corners are: squares of kSide px, turned by an angle, corner (0, 0) at (u0, v0).
struct FlatBoard {
  static constexpr double kSide = 27.3;
  double u0 = 71.37, v0 = 33.81, turn = 0.19;
  int rows = 12, columns = 18;

  [[nodiscard]] double u(int row, int column) const { return u0 + kSide * (column * std::cos(turn) - row * std::sin(turn)); }
  [[nodiscard]] double v(int row, int column) const { return v0 + kSide * (column * std::sin(turn) + row * std::cos(turn)); }
  // Edges of this blur, a normal distribution; noise of the sensor, then whole grey levels.
  [[nodiscard]] FilmedPicture picture(int width, int height, double blur, double noise, std::mt19937& random) const {
    std::normal_distribution<double> normal(0, noise);
    FilmedPicture picture{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height))};
    // Between two lines an edge is one of them only: 27 px are 30 blurs.
    const auto wave = [&](double x) {
      const double line = std::round(x / kSide);
      const double sign = std::fmod(std::abs(line), 2) < 0.5 ? 1 : -1;
      return sign * std::erf((x - line * kSide) / (blur * M_SQRT2));
    };
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double along = (x - u0) * std::cos(turn) + (y - v0) * std::sin(turn);
        const double across = -(x - u0) * std::sin(turn) + (y - v0) * std::cos(turn);
        const double level = 120 + 90 * wave(along) * wave(across) + normal(random);
        picture.pixels[static_cast<std::size_t>(y * width + x)] =
            static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
      }
    return picture;
  }
};

FilmedPicture board_picture(int width, int height, unsigned seed = 1) {
  std::mt19937 random(seed);
  return FlatBoard{}.picture(width, height, 0.9, 2, random);
}

// By libjpeg with its own memory and source.
std::vector<std::uint8_t> decoded_by_libjpeg(const std::vector<std::uint8_t>& bytes) {
  jpeg_decompress_struct jpeg;
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, bytes.data(), bytes.size());
  EXPECT_EQ(jpeg_read_header(&jpeg, TRUE), JPEG_HEADER_OK);
  jpeg.out_color_space = JCS_GRAYSCALE;
  jpeg.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&jpeg);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(jpeg.output_width) * jpeg.output_height);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = pixels.data() + static_cast<std::size_t>(jpeg.output_scanline) * jpeg.output_width;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  jpeg_destroy_decompress(&jpeg);
  return pixels;
}

TEST(GrayJpeg, IsLibjpegsOwnBrightnessToTheLastBit) {
  for (const auto& [width, height] : {std::pair{1, 1}, {33, 17}, {64, 48}, {640, 360}, {1283, 64}})
    for (const fakes::JpegKind& kind :
         {fakes::JpegKind{}, {70, false, true, false, 0}, {95, true, false, false, 0}, {85, true, true, false, 2}}) {
      const FilmedPicture picture = board_picture(width, height);
      const std::vector<std::uint8_t> jpeg = fakes::jpeg_of(picture.view(), kind);
      GrayJpegDecoder decoder(width, height);
      const int stride = width + 7;
      std::vector<std::uint8_t> to(static_cast<std::size_t>(stride * height), 0xa5);
      for (int again = 0; again < 2; ++again) ASSERT_TRUE(decoder.decode(jpeg, to.data(), stride)) << width;
      const std::vector<std::uint8_t> wanted =
          decoded_by_libjpeg(kind.tables ? jpeg : fakes::jpeg_of(picture.view(), {kind.quality, kind.colour}));
      for (int v = 0; v < height; ++v)
        for (int u = 0; u < stride; ++u)
          ASSERT_EQ(to[static_cast<std::size_t>(v * stride + u)],
                    u < width ? wanted[static_cast<std::size_t>(v * width + u)] : 0xa5)
              << u << ", " << v;
    }
}

TEST(GrayJpeg, WhatIsNotWholeIsRefusedAndTheNextImageIsGood) {
  const FilmedPicture picture = board_picture(640, 360);
  const std::vector<std::uint8_t> jpeg = fakes::jpeg_of(picture.view(), {85, true, false});
  GrayJpegDecoder decoder(640, 360);
  std::vector<std::uint8_t> to(640 * 360);
  std::mt19937 random(5);
  const auto good = [&] { return decoder.decode(jpeg, to.data(), 640); };
  int unseen = 0;
  ASSERT_TRUE(good());
  EXPECT_FALSE(decoder.decode({}, to.data(), 640));
  for (int draw = 0; draw < 200; ++draw) {
    // Cut anywhere but in the marker at the end; a packet lost in the scan; a packet of noise in it.
    const std::size_t at = 1000 + random() % (jpeg.size() - 2000), packet = 64 + random() % 700;
    EXPECT_FALSE(decoder.decode(std::span(jpeg).first(random() % (jpeg.size() - 2)), to.data(), 640));
    std::vector<std::uint8_t> lost = jpeg;
    lost.erase(lost.begin() + static_cast<std::ptrdiff_t>(at), lost.begin() + static_cast<std::ptrdiff_t>(at + packet));
    EXPECT_FALSE(decoder.decode(lost, to.data(), 640)) << packet << " bytes from " << at;
    std::vector<std::uint8_t> noisy = jpeg;
    for (std::size_t i = 0; i < packet; ++i) noisy[at + i] = static_cast<std::uint8_t>(random());
    unseen += decoder.decode(noisy, to.data(), 640) ? 1 : 0;
  }
  // Bytes that are other ones may code as many blocks as the right ones. Transmissions lose packets; they do not make them up.
  std::printf("  %d of 200 packets of noise were not seen\n", unseen);
  EXPECT_LE(unseen, 20);
  EXPECT_TRUE(good());
  // What a driver leaves behind the image in a buffer is none of it.
  std::vector<std::uint8_t> padded = jpeg;
  padded.resize(jpeg.size() + 5000, 0);
  EXPECT_TRUE(decoder.decode(padded, to.data(), 640));
}

TEST(GrayJpeg, OfAnotherKindOrSizeIsRefused) {
  const FilmedPicture picture = board_picture(640, 360), smaller = board_picture(320, 240);
  GrayJpegDecoder decoder(640, 360);
  std::vector<std::uint8_t> to(640 * 360);
  EXPECT_FALSE(decoder.decode(fakes::jpeg_of(picture.view(), {85, true, true, true}), to.data(), 640)) << "progressive";
  EXPECT_FALSE(decoder.decode(fakes::jpeg_of(smaller.view()), to.data(), 640)) << "another size";
  EXPECT_FALSE(decoder.decode(picture.pixels, to.data(), 640)) << "no JPEG";
  EXPECT_TRUE(decoder.decode(fakes::jpeg_of(picture.view()), to.data(), 640));
}

TEST(GrayJpeg, GoodAndBadFramesTakeNothingFromTheHeap) {
  if (!fakes::AllocationGauge::works()) GTEST_SKIP() << "the sanitizer has its own malloc";
  const FilmedPicture picture = board_picture(640, 360);
  std::vector<std::vector<std::uint8_t>> frames{
      fakes::jpeg_of(picture.view()), fakes::jpeg_of(picture.view(), {95, true, false}),
      fakes::jpeg_of(picture.view(), {70, false}), fakes::jpeg_of(picture.view(), {85, true, true, true}),
      fakes::jpeg_of(board_picture(320, 240).view())};
  frames.push_back(frames[0]);
  frames.back().resize(frames[0].size() / 2);
  GrayJpegDecoder decoder(640, 360);
  std::vector<std::uint8_t> to(640 * 360);
  int good = 0;
  {
    const fakes::AllocationGauge gauge;
    for (int n = 0; n < 300; ++n)
      good += decoder.decode(frames[static_cast<std::size_t>(n) % frames.size()], to.data(), 640) ? 1 : 0;
    EXPECT_EQ(gauge.count(), 0);
  }
  EXPECT_EQ(good, 150);
  {
    const fakes::AllocationGauge gauge;
    static_cast<void>(decoded_by_libjpeg(frames[0]));
    EXPECT_GT(gauge.count(), 3) << "libjpeg with its own memory: the gauge sees it";
  }
  std::printf("  %zu of %zu bytes reserved were used\n", decoder.used(), decoder.reserved());
  EXPECT_LT(2 * decoder.used(), decoder.reserved());
  // The widest images that a camera may have: rows of blocks grow with the width alone.
  const FilmedPicture wide = board_picture(8192, 32);
  GrayJpegDecoder large(8192, 32);
  std::vector<std::uint8_t> wide_to(8192 * 32);
  EXPECT_TRUE(large.decode(fakes::jpeg_of(wide.view()), wide_to.data(), 8192));
  EXPECT_LT(2 * large.used(), large.reserved());
}

// What compression does to corners: errors against their true places, and what they state of them.
struct CornerErrors {
  double rms = 0, stated = 0;
  int corners = 0;
  double bytes = 0;
  double decoding_s = 1e9, finding_s = 1e9;  // the shortest
};

template <class Work>
void time_shortest(double& shortest, Work work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  shortest = std::min(shortest, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
}

CornerErrors errors_at(int quality) {
  constexpr int kPictures = 6;
  CornerErrors errors;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  GrayJpegDecoder decoder(640, 480);
  dsp::BoardFinder finder(640, 480, 1024);
  dsp::DetectorOptions options;
  options.min_distance = 8;
  for (int n = 0; n < kPictures; ++n) {
    FlatBoard board;
    board.u0 += 8 * unit(random);
    board.v0 += 8 * unit(random);
    board.turn += 0.3 * unit(random);
    FilmedPicture picture = board.picture(640, 480, 0.9, 2, random);
    if (quality > 0) {
      const std::vector<std::uint8_t> jpeg = fakes::jpeg_of(picture.view(), {quality});
      errors.bytes += static_cast<double>(jpeg.size()) / kPictures;
      time_shortest(errors.decoding_s, [&] { EXPECT_TRUE(decoder.decode(jpeg, picture.pixels.data(), 640)); });
    }
    time_shortest(errors.finding_s, [&] { (void)finder.find(picture.view(), options); });
    const auto grid = finder.find(picture.view(), options);
    EXPECT_TRUE(grid.ok());
    for (const int cell : grid->cells) {
      if (cell < 0) continue;
      const dsp::Corner& corner = finder.corners()[static_cast<std::size_t>(cell)].corner;
      const double u = corner.u.to<double>(), v = corner.v.to<double>();
      // The pattern goes on over the whole image: the nearest line of each kind.
      const double x = (u - board.u0) * std::cos(board.turn) + (v - board.v0) * std::sin(board.turn);
      const double y = -(u - board.u0) * std::sin(board.turn) + (v - board.v0) * std::cos(board.turn);
      const auto off = [](double place) { return place - FlatBoard::kSide * std::round(place / FlatBoard::kSide); };
      errors.rms += off(x) * off(x) + off(y) * off(y);
      const double sigma = corner.sigma_q12 / 4096.0;
      errors.stated += 2 * sigma * sigma;
      ++errors.corners;
    }
  }
  errors.rms = std::sqrt(errors.rms / (2 * errors.corners));
  errors.stated = std::sqrt(errors.stated / (2 * errors.corners));
  return errors;
}

TEST(GrayJpeg, CornersScatterMoreTheMoreIsLostAndSaySo) {
  const CornerErrors raw = errors_at(0);
  double before = raw.rms;
  std::printf("  raw: %d corners, %.4f px rms per axis, stated %.4f\n", raw.corners, raw.rms, raw.stated);
  EXPECT_NEAR(raw.stated / raw.rms, 1, 0.15);
  for (const int quality : {95, 85, 70}) {
    const CornerErrors errors = errors_at(quality);
    std::printf("  quality %d: %.2f bits a pixel, %.4f px rms per axis, %.2f of raw, stated %.2f of it; ", quality,
                8 * errors.bytes / (640 * 480), errors.rms, errors.rms / raw.rms, errors.stated / errors.rms);
    std::printf("decoding takes %.2f of finding the board\n", errors.decoding_s / errors.finding_s);
    EXPECT_NEAR(errors.corners, raw.corners, 0.005 * raw.corners);
    EXPECT_GT(errors.rms, 0.98 * before);
    EXPECT_NEAR(errors.stated / errors.rms, 1, 0.3);
    before = errors.rms;
  }
}

}  // namespace
}  // namespace srd
