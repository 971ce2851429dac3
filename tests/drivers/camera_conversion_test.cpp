// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "drivers/camera/gray_conversion.hpp"

namespace srd {
namespace {

// One pixel, as the format's definition reads.
std::uint8_t one(GrayLayout layout, int bits, const std::uint8_t* row, int u) {
  if (layout == GrayLayout::kBytes) return row[u];
  if (layout == GrayLayout::kEvenBytes) return row[2 * u];
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
    const auto layout = static_cast<GrayLayout>(random() % 5);
    const int bits = layout == GrayLayout::kLittleEndian ? 8 + static_cast<int>(random() % 9) : 8;
    const int width = 1 + static_cast<int>(random() % 150), height = 1 + static_cast<int>(random() % 5);
    const int from_stride = width * bytes_per_pixel(layout) + static_cast<int>(random() % 20);
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

}  // namespace
}  // namespace srd
