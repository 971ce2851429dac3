// SPDX-License-Identifier: Apache-2.0
// A mode as one byte: 10 m + n for A_mn, 100 for B, 101 for C.
#pragma once

#include <cstdint>
#include <span>

#include "dsp/optics/surface_model.hpp"

namespace srd::proto {

[[nodiscard]] constexpr std::uint8_t mode_code(const dsp::Mode& mode) {
  switch (mode.kind) {
    case dsp::Mode::Kind::kSlopeX: return 100;
    case dsp::Mode::Kind::kSlopeY: return 101;
    case dsp::Mode::Kind::kCosine: break;
  }
  return static_cast<std::uint8_t>(10 * mode.m + mode.n);
}

// kInvalidArgument for an unknown code, none or a mode twice; kTooSmall for too many.
[[nodiscard]] inline Result<dsp::ModeList> mode_list(std::span<const std::uint8_t> codes) {
  if (codes.size() > dsp::kMaxModes) return Errc::kTooSmall;
  std::array<dsp::Mode, dsp::kMaxModes> modes;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const std::uint8_t code = codes[i];
    if (code > 101) return Errc::kInvalidArgument;
    if (code >= 100)
      modes[i] = {code == 100 ? dsp::Mode::Kind::kSlopeX : dsp::Mode::Kind::kSlopeY, 0, 0};
    else
      modes[i] = {dsp::Mode::Kind::kCosine, static_cast<std::uint8_t>(code / 10), static_cast<std::uint8_t>(code % 10)};
  }
  return dsp::ModeList::make(std::span(modes).first(codes.size()));
}

}  // namespace srd::proto
