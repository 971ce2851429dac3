// SPDX-License-Identifier: Apache-2.0
// The 16 samples on a circle of radius 5 or 10 that the response reads. Optics (22), in OpenSRD's order: n = 0 at the top,
// clockwise in the image.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace srd::dsp {

struct Offset {
  std::int8_t x, y;
};

inline constexpr std::array<Offset, 16> kRing5{{{0, -5},
                                                {2, -5},
                                                {4, -4},
                                                {5, -2},
                                                {5, 0},
                                                {5, 2},
                                                {4, 4},
                                                {2, 5},
                                                {0, 5},
                                                {-2, 5},
                                                {-4, 4},
                                                {-5, 2},
                                                {-5, 0},
                                                {-5, -2},
                                                {-4, -4},
                                                {-2, -5}}};
inline constexpr std::array<Offset, 16> kRing10{{{0, -10},
                                                 {4, -10},
                                                 {7, -7},
                                                 {10, -4},
                                                 {10, 0},
                                                 {10, 4},
                                                 {7, 7},
                                                 {4, 10},
                                                 {0, 10},
                                                 {-4, 10},
                                                 {-7, 7},
                                                 {-10, 4},
                                                 {-10, 0},
                                                 {-10, -4},
                                                 {-7, -7},
                                                 {-4, -10}}};

[[nodiscard]] constexpr const std::array<Offset, 16>& ring(int radius) { return radius == 10 ? kRing10 : kRing5; }

// The samples' distances from the centre in an image of this stride, bytes.
[[nodiscard]] constexpr std::array<std::ptrdiff_t, 16> sample_distances(int radius, std::ptrdiff_t stride) {
  std::array<std::ptrdiff_t, 16> at{};
  const auto& offsets = ring(radius);
  for (std::size_t n = 0; n < 16; ++n) at[n] = offsets[n].y * stride + offsets[n].x;
  return at;
}

}  // namespace srd::dsp
