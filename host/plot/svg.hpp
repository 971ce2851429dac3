// SPDX-License-Identifier: Apache-2.0
// A scene as an SVG element that can stand inside an HTML page: no reference to anything outside.
#pragma once

#include <string>

#include "drivers/support/problem.hpp"
#include "host/plot/scene.hpp"

namespace srd::host {

// label: what the figure shows, for readers that cannot see it.
[[nodiscard]] Outcome<std::string> svg_element(const Scene& scene, const std::string& label);

// &, <, > and quotes as entities.
[[nodiscard]] std::string escaped(const std::string& text);

}  // namespace srd::host
