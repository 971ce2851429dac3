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

}  // namespace

void convert_to_gray(GrayLayout layout, int bits, const std::uint8_t* from, int from_stride, std::uint8_t* to, int to_stride,
                     int width, int height) noexcept {
  for (int v = 0; v < height; ++v, from += from_stride, to += to_stride) switch (layout) {
      case GrayLayout::kBytes: std::memcpy(to, from, static_cast<std::size_t>(width)); break;
      case GrayLayout::kEvenBytes: even_bytes(from, to, width); break;
      case GrayLayout::kLittleEndian: high_bits_of(bits, from, to, width); break;
      case GrayLayout::kRgb: luma<0, 2>(from, to, width); break;
      case GrayLayout::kBgr: luma<2, 0>(from, to, width); break;
    }
}

}  // namespace srd
