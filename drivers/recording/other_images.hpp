// SPDX-License-Identifier: Apache-2.0
// Image formats beyond PGM and PNG.
#pragma once

#include <string>

#include "drivers/recording/image_file.hpp"

namespace srd {

// BMP, TIFF, JPEG and what else OpenCV decodes. Only in programs that link srd_other_images: OpenCV's decoders bring more
// than a hundred shared libraries, which a board would load and lock into its memory for nothing. Null elsewhere.
[[nodiscard, gnu::weak]] bool read_other_image(const std::string& file, GrayImage& image, int sample_bits) noexcept;

}  // namespace srd
