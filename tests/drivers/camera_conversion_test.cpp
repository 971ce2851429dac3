// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "drivers/camera/gray_conversion.hpp"
#include "dsp/frontend/board_finder.hpp"

namespace srd {
namespace {

// One pixel, as the format's definition reads.
std::uint8_t one(GrayLayout layout, int bits, const std::uint8_t* row, int u) {
  if (layout == GrayLayout::kBytes) return row[u];
  if (layout == GrayLayout::kEvenBytes) return row[2 * u];
  if (layout == GrayLayout::kPackedTen) return row[5 * (u / 4) + u % 4];
  if (layout == GrayLayout::kRgb)
    return static_cast<std::uint8_t>((77u * row[3 * u] + 150u * row[3 * u + 1] + 29u * row[3 * u + 2]) / 256);
  if (layout == GrayLayout::kBgr)
    return static_cast<std::uint8_t>((77u * row[3 * u + 2] + 150u * row[3 * u + 1] + 29u * row[3 * u]) / 256);
  const unsigned value = row[2 * u] + 256u * row[2 * u + 1];
  return static_cast<std::uint8_t>(value / (1u << (bits - 8)));
}

TEST(GrayConversion, EqualsTheDefinitionForAllSizesStridesAndMisalignments) {
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    const auto layout = static_cast<GrayLayout>(random() % 6);
    const int bits = layout == GrayLayout::kLittleEndian ? 8 + static_cast<int>(random() % 9) : 8;
    const int width = 1 + static_cast<int>(random() % 150), height = 1 + static_cast<int>(random() % 5);
    const int from_stride = row_bytes(layout, width) + static_cast<int>(random() % 20);
    const int to_stride = width + static_cast<int>(random() % 20);
    const std::size_t from_at = random() % 4, to_at = random() % 4;
    std::vector<std::uint8_t> from(from_at + static_cast<std::size_t>(from_stride * height));
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = static_cast<std::uint8_t>(random());
    if (layout == GrayLayout::kLittleEndian && bits < 16)  // the unused bits of a pixel are 0
      for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u)
          from[from_at + static_cast<std::size_t>(v * from_stride + 2 * u + 1)] &=
              static_cast<std::uint8_t>((1 << (bits - 8)) - 1);
    std::vector<std::uint8_t> to(to_at + static_cast<std::size_t>(to_stride * height), 0xa5);
    convert_to_gray(layout, bits, from.data() + from_at, from_stride, to.data() + to_at, to_stride, width, height);
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < to_stride; ++u) {
        const std::uint8_t wanted = u < width ? one(layout, bits, from.data() + from_at + v * from_stride, u) : 0xa5;
        ASSERT_EQ(to[to_at + static_cast<std::size_t>(v * to_stride + u)], wanted)
            << "layout " << static_cast<int>(layout) << " bits " << bits << " at " << u << ", " << v;
      }
  }
}

TEST(GrayConversion, KeepsTheHighestBits) {
  // 10 bits: 1023 -> 255, 1020 -> 255, 1019 -> 254, 3 -> 0.
  const std::vector<std::uint8_t> ten{0xff, 0x03, 0xfc, 0x03, 0xfb, 0x03, 0x03, 0x00};
  std::vector<std::uint8_t> gray(4);
  convert_to_gray(GrayLayout::kLittleEndian, 10, ten.data(), 8, gray.data(), 4, 4, 1);
  EXPECT_EQ(gray, (std::vector<std::uint8_t>{255, 255, 254, 0}));
}

// A mosaic's sample as its format's definition reads, of all its bits.
unsigned mosaic_sample(GrayLayout layout, const std::uint8_t* row, int u) {
  if (layout == GrayLayout::kBytes) return row[u];
  if (layout == GrayLayout::kLittleEndian) return row[2 * u] + 256u * row[2 * u + 1];
  return 4u * row[5 * (u / 4) + u % 4] + ((row[5 * (u / 4) + 4] / (1u << (2 * (u % 4)))) % 4u);
}

TEST(GrayConversion, HalvesMosaicsAsTheirDefinitionForAllSizesAndStrides) {
  std::mt19937 random(8);
  for (int round = 0; round < 300; ++round) {
    const GrayLayout layout = std::array{GrayLayout::kBytes, GrayLayout::kLittleEndian, GrayLayout::kPackedTen}[random() % 3];
    const int bits = layout == GrayLayout::kBytes       ? 8
                     : layout == GrayLayout::kPackedTen ? 10
                                                        : 8 + static_cast<int>(random() % 9);
    const Mosaic mosaic = random() % 2 == 0 ? Mosaic::kGreenAside : Mosaic::kGreenFirst;
    const MosaicGray gray = random() % 2 == 0 ? MosaicGray::kGreen : MosaicGray::kAll;
    const int width = 1 + static_cast<int>(random() % 70), height = 1 + static_cast<int>(random() % 5);
    const int from_stride = row_bytes(layout, 2 * width) + static_cast<int>(random() % 20),
              to_stride = width + static_cast<int>(random() % 9);
    std::vector<std::uint8_t> from(static_cast<std::size_t>(from_stride * 2 * height) + 1);
    for (std::uint8_t& byte : from) byte = static_cast<std::uint8_t>(random());
    if (layout == GrayLayout::kLittleEndian && bits < 16)
      for (int v = 0; v < 2 * height; ++v)
        for (int u = 0; u < 2 * width; ++u)
          from[static_cast<std::size_t>(v * from_stride + 2 * u + 1)] &= static_cast<std::uint8_t>((1 << (bits - 8)) - 1);
    std::vector<std::uint8_t> to(static_cast<std::size_t>(to_stride * height), 0xa5);
    halve_mosaic(layout, bits, mosaic, gray, from.data(), from_stride, to.data(), to_stride, width, height);
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < to_stride; ++u) {
        unsigned wanted = 0xa5;
        if (u < width) {
          unsigned sum = 0, n = 0;
          for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 2; ++x) {
              const bool green = (x == y) == (mosaic == Mosaic::kGreenFirst);
              if (gray == MosaicGray::kGreen && !green) continue;
              sum += mosaic_sample(layout, from.data() + static_cast<std::ptrdiff_t>(2 * v + y) * from_stride, 2 * u + x);
              ++n;
            }
          wanted = sum / n / (1u << (bits - 8));
        }
        ASSERT_EQ(to[static_cast<std::size_t>(v * to_stride + u)], wanted) << bits << " bits at " << u << ", " << v;
      }
  }
}

// A board of which a colour sensor's mosaic is taken, each colour with its own brightness.
struct MosaicOffsets {
  double u = 0, v = 0;
  int corners = 0;
};

// Mean error of the corners in the halved image against u_half = (u - 0.5) / 2. RGGB.
MosaicOffsets mosaic_offsets(MosaicGray gray, double red, double green, double blue) {
  constexpr int kWidth = 960, kHeight = 720;
  constexpr double kSide = 53.7, kTurn = 0.21, kBlur = 1.8;
  const auto wave = [&](double x) {
    const double line = std::round(x / kSide);
    return (std::fmod(std::abs(line), 2) < 0.5 ? 1 : -1) * std::erf((x - line * kSide) / (kBlur * M_SQRT2));
  };
  const auto along = [&](double u, double v) { return u * std::cos(kTurn) + v * std::sin(kTurn) - 31.3; };
  const auto across = [&](double u, double v) { return -u * std::sin(kTurn) + v * std::cos(kTurn) - 12.9; };
  std::vector<std::uint8_t> mosaic(kWidth * kHeight), half(kWidth * kHeight / 4);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double gain = u % 2 != v % 2 ? green : u % 2 == 0 ? red : blue;
      mosaic[static_cast<std::size_t>(v * kWidth + u)] =
          static_cast<std::uint8_t>(std::lround(gain * (120 + 100 * wave(along(u, v)) * wave(across(u, v)))));
    }
  halve_mosaic(GrayLayout::kBytes, 8, Mosaic::kGreenAside, gray, mosaic.data(), kWidth, half.data(), kWidth / 2, kWidth / 2,
               kHeight / 2);
  dsp::BoardFinder finder(kWidth / 2, kHeight / 2, 1024);
  dsp::DetectorOptions options;
  options.threshold = 50;
  options.min_distance = 8;
  MosaicOffsets offsets;
  const auto grid = finder.find({half.data(), kWidth / 2, kHeight / 2, kWidth / 2}, options);
  EXPECT_TRUE(grid.ok());
  for (const int cell : grid->cells) {
    if (cell < 0) continue;
    const dsp::Corner& corner = finder.corners()[static_cast<std::size_t>(cell)].corner;
    const double u = 2 * corner.u.to<double>() + 0.5, v = 2 * corner.v.to<double>() + 0.5;
    const double x = along(u, v), y = across(u, v);
    const double off_x = x - kSide * std::round(x / kSide), off_y = y - kSide * std::round(y / kSide);
    offsets.u += (off_x * std::cos(kTurn) - off_y * std::sin(kTurn)) / 2;
    offsets.v += (off_x * std::sin(kTurn) + off_y * std::cos(kTurn)) / 2;
    ++offsets.corners;
  }
  offsets.u /= offsets.corners;
  offsets.v /= offsets.corners;
  return offsets;
}

TEST(GrayConversion, AHalvedCornerIsWhereItsCellsAreWhateverTheLightForGreen) {
  for (const auto& [red, green, blue] : {std::array{1.0, 1.0, 1.0}, {0.3, 1.0, 0.7}, {1.0, 0.6, 0.1}}) {
    const MosaicOffsets found = mosaic_offsets(MosaicGray::kGreen, red, green, blue);
    EXPECT_GT(found.corners, 60);
    EXPECT_NEAR(found.u, 0, 0.004);
    EXPECT_NEAR(found.v, 0, 0.004);
  }
}

TEST(GrayConversion, AllFourPixelsMeetWhereTheirBrightnessIs) {
  for (const auto& [red, green, blue] : {std::array{1.0, 1.0, 1.0}, {1.0, 0.3, 0.1}, {0.1, 0.3, 1.0}}) {
    const MosaicOffsets found = mosaic_offsets(MosaicGray::kAll, red, green, blue);
    EXPECT_GT(found.corners, 60);
    // Red lies half a pixel of the mosaic up and left of the cell's middle, blue down and right. What is brighter up and left
    // sees the corner further down and right in its own pixels' places: it shows it too far down and right.
    const double expected = 0.25 * (red - blue) / (red + 2 * green + blue);
    EXPECT_NEAR(found.u, expected, 0.004);
    EXPECT_NEAR(found.v, expected, 0.004);
  }
}

}  // namespace
}  // namespace srd
