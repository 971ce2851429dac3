// SPDX-License-Identifier: Apache-2.0
#include "host/plot/palette.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace srd::host {

Colour viridis(double at) {
  // Every tenth of the published table; straight lines between stay within 3 of 255 of it.
  static constexpr std::array<std::array<double, 3>, 11> kTable{{{68, 1, 84},
                                                                 {72, 36, 117},
                                                                 {65, 68, 135},
                                                                 {53, 95, 141},
                                                                 {42, 120, 142},
                                                                 {33, 145, 140},
                                                                 {34, 168, 132},
                                                                 {68, 191, 112},
                                                                 {122, 209, 81},
                                                                 {189, 223, 38},
                                                                 {253, 231, 37}}};
  const double scaled = std::clamp(std::isfinite(at) ? at : 0.0, 0.0, 1.0) * (kTable.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(scaled), kTable.size() - 2);
  const double part = scaled - static_cast<double>(below);
  const auto channel = [&](std::size_t i) {
    return static_cast<std::uint8_t>(std::lround(kTable[below][i] * (1 - part) + kTable[below + 1][i] * part));
  };
  return {channel(0), channel(1), channel(2)};
}

Colour status_colour(std::string_view status) {
  if (status == "lost") return kVermilion;
  if (status == "searching") return kPurple;
  if (status == "poor_fit" || status == "inconsistent" || status == "interlaced") return kGreen;
  if (status == "too_few_corners") return kSky;
  if (status == "dropped") return {140, 140, 140};
  return kBlack;
}

}  // namespace srd::host
