// SPDX-License-Identifier: Apache-2.0
// PNG files by libpng: any kind is read as 8-bit grey, 8-bit grey is written.
#pragma once

#include <string>

#include "drivers/recording/image_file.hpp"

namespace srd {

// By the file's first bytes.
[[nodiscard]] bool is_png(const std::string& file) noexcept;

// Samples as read_gray_image takes them, colour is weighed 0.299, 0.587, 0.114, transparency is ignored.
// False: no whole PNG.
[[nodiscard]] bool read_png(const std::string& file, GrayImage& image, int sample_bits) noexcept;

// level: 0 fastest to 9 smallest. False when it cannot be written whole; errno says why when the system refused.
[[nodiscard]] bool write_png(const std::string& file, const GrayView& image, int level) noexcept;

}  // namespace srd
