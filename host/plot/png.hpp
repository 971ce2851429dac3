// SPDX-License-Identifier: Apache-2.0
// Drawings as PNG, by cairo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "drivers/support/problem.hpp"
#include "host/plot/scene.hpp"

namespace srd::host {

// 960 units wide makes 2400 pixels: 300 dots an inch over 200 mm.
inline constexpr double kPngPixelsPerUnit = 2.5;

// kInput when the file cannot be written.
[[nodiscard]] Outcome<void> write_png(const Scene& scene, const std::filesystem::path& file);

// An image's own pixels as a PNG file in memory.
[[nodiscard]] Outcome<std::vector<std::uint8_t>> png_bytes(const Image& image);

}  // namespace srd::host
