// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/gray_conversion.hpp"

#include <cstring>

namespace srd {

namespace {

// Plain loops over bytes: they mean the same on every byte order and alignment, and compilers make vector code of them
// (this file is built with -O3).
void even_bytes(const std::uint8_t* __restrict from, std::uint8_t* __restrict to, int width) noexcept {
  for (int i = 0; i < width; ++i) to[i] = from[2 * i];
}

// 77 + 150 + 29 = 256: the sum is below 2^16.
template <int kRed, int kBlue>
void luma(const std::uint8_t* __restrict from, std::uint8_t* __restrict to, int width) noexcept {
  for (int i = 0; i < width; ++i)
    to[i] = static_cast<std::uint8_t>((77 * from[3 * i + kRed] + 150 * from[3 * i + 1] + 29 * from[3 * i + kBlue]) >> 8);
}

template <int kBits>
void high_bits(const std::uint8_t* __restrict from, std::uint8_t* __restrict to, int width) noexcept {
  constexpr int kDown = kBits - 8;
  for (int i = 0; i < width; ++i) to[i] = static_cast<std::uint8_t>((from[2 * i] >> kDown) | (from[2 * i + 1] << (8 - kDown)));
}

void high_bits_of(int bits, const std::uint8_t* from, std::uint8_t* to, int width) noexcept {
  switch (bits) {
    case 8: return high_bits<8>(from, to, width);
    case 9: return high_bits<9>(from, to, width);
    case 10: return high_bits<10>(from, to, width);
    case 11: return high_bits<11>(from, to, width);
    case 12: return high_bits<12>(from, to, width);
    case 13: return high_bits<13>(from, to, width);
    case 14: return high_bits<14>(from, to, width);
    case 15: return high_bits<15>(from, to, width);
    default: return high_bits<16>(from, to, width);
  }
}

void high_bytes_of_ten(const std::uint8_t* __restrict from, std::uint8_t* __restrict to, int width) noexcept {
  for (int i = 0; i < width; ++i) to[i] = from[i + i / 4];
}

// Sample i of a row, whole.
template <GrayLayout kLayout>
unsigned sample(const std::uint8_t* row, int i) noexcept {
  if constexpr (kLayout == GrayLayout::kBytes) return row[i];
  if constexpr (kLayout == GrayLayout::kLittleEndian) return row[2 * i] | static_cast<unsigned>(row[2 * i + 1]) << 8;
  const std::uint8_t* four = row + 5 * (i / 4);
  return static_cast<unsigned>(four[i % 4]) << 2 | ((four[4] >> (2 * (i % 4))) & 3U);
}

template <GrayLayout kLayout>
void halve_row(int bits, Mosaic mosaic, MosaicGray gray, const std::uint8_t* __restrict upper,
               const std::uint8_t* __restrict lower, std::uint8_t* __restrict to, int width) noexcept {
  // Two samples of 16 bits have 17, four have 18.
  const int down = bits - 8 + (gray == MosaicGray::kAll ? 2 : 1);
  const int above = mosaic == Mosaic::kGreenFirst ? 0 : 1, below = 1 - above;
  if (gray == MosaicGray::kAll)
    for (int i = 0; i < width; ++i)
      to[i] = static_cast<std::uint8_t>((sample<kLayout>(upper, 2 * i) + sample<kLayout>(upper, 2 * i + 1) +
                                         sample<kLayout>(lower, 2 * i) + sample<kLayout>(lower, 2 * i + 1)) >>
                                        down);
  else
    for (int i = 0; i < width; ++i)
      to[i] =
          static_cast<std::uint8_t>((sample<kLayout>(upper, 2 * i + above) + sample<kLayout>(lower, 2 * i + below)) >> down);
}

}  // namespace

void convert_to_gray(GrayLayout layout, int bits, const std::uint8_t* from, int from_stride, std::uint8_t* to, int to_stride,
                     int width, int height) noexcept {
  for (int v = 0; v < height; ++v, from += from_stride, to += to_stride) switch (layout) {
      case GrayLayout::kBytes: std::memcpy(to, from, static_cast<std::size_t>(width)); break;
      case GrayLayout::kEvenBytes: even_bytes(from, to, width); break;
      case GrayLayout::kLittleEndian: high_bits_of(bits, from, to, width); break;
      case GrayLayout::kRgb: luma<0, 2>(from, to, width); break;
      case GrayLayout::kBgr: luma<2, 0>(from, to, width); break;
      case GrayLayout::kPackedTen: high_bytes_of_ten(from, to, width); break;
      case GrayLayout::kJpeg: break;
    }
}

void halve_mosaic(GrayLayout layout, int bits, Mosaic mosaic, MosaicGray gray, const std::uint8_t* from, int from_stride,
                  std::uint8_t* to, int to_stride, int width, int height) noexcept {
  for (int v = 0; v < height; ++v, from += 2 * static_cast<std::ptrdiff_t>(from_stride), to += to_stride) {
    const std::uint8_t* below = from + from_stride;
    switch (layout) {
      case GrayLayout::kLittleEndian: halve_row<GrayLayout::kLittleEndian>(bits, mosaic, gray, from, below, to, width); break;
      case GrayLayout::kPackedTen: halve_row<GrayLayout::kPackedTen>(10, mosaic, gray, from, below, to, width); break;
      default: halve_row<GrayLayout::kBytes>(8, mosaic, gray, from, below, to, width); break;
    }
  }
}

}  // namespace srd
