// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/modes_key.hpp"

#include <string>
#include <vector>

namespace srd {

std::optional<dsp::ModeList> read_modes(TomlTable& surface) {
  const auto parameters = surface.integer("parameters", {1, 24});
  const auto names = surface.texts("modes");
  if (names && parameters) surface.complain("modes", "either parameters or modes", "both", "leave one of them out");
  if (names) {
    std::vector<dsp::Mode> modes;
    for (const std::string& name : *names) {
      const auto mode = dsp::Mode::parse(name);
      if (!mode) {
        surface.complain("modes", "names such as A00, B, C, A10, A01, A21", "\"" + name + "\"");
        return std::nullopt;
      }
      modes.push_back(*mode);
    }
    if (const auto list = dsp::ModeList::make(modes)) return *list;
    surface.complain("modes", "1 to 24 different modes", std::to_string(modes.size()) + " names, or one twice");
    return std::nullopt;
  }
  if (!parameters) return std::nullopt;
  if (const auto list = dsp::ModeList::standard(static_cast<int>(*parameters))) return *list;
  surface.complain("parameters", "1, 3, 5, 8 or 12 (or a list of modes)", std::to_string(*parameters));
  return std::nullopt;
}

}  // namespace srd
