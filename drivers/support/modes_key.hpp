// SPDX-License-Identifier: Apache-2.0
// The modes of a surface in a TOML table: modes = ["A00", "B", ..] or parameters = 1, 3, 5, 8 or 12.
#pragma once

#include <optional>

#include "drivers/support/toml_reader.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd {

// nullopt: neither is given, or what is given is wrong, and the table has complained.
[[nodiscard]] std::optional<dsp::ModeList> read_modes(TomlTable& surface);

}  // namespace srd
