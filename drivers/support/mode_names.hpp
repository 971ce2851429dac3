// SPDX-License-Identifier: Apache-2.0
// The names of a surface's modes in texts: "A00,B,C".
#pragma once

#include <string>
#include <string_view>

#include "dsp/optics/surface_model.hpp"

namespace srd {

[[nodiscard]] inline std::string mode_name(const dsp::Mode& mode) { return mode.name().data(); }

// prefix: before each name, as "sd_".
[[nodiscard]] inline std::string joined(const dsp::ModeList& modes, std::string_view between, std::string_view prefix = {}) {
  std::string names;
  for (const dsp::Mode& mode : modes) {
    if (!names.empty()) names += between;
    names.append(prefix) += mode_name(mode);
  }
  return names;
}

}  // namespace srd
