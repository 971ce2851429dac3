// SPDX-License-Identifier: Apache-2.0
// Binary PGM files (P5), read without the heap.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "drivers/recording/image_file.hpp"

namespace srd {

struct PgmSize {
  int width = 0, height = 0;  // px
  std::size_t bytes = 0;      // that the pixels take in the file
};

// Nothing: no PGM.
[[nodiscard]] std::optional<PgmSize> pgm_size(const std::string& file) noexcept;

// In: bits of samples of two bytes, 0: those of the header's maximum. Out: GrayImage::sample_bits and bits_set.
struct PgmSamples {
  int bits = 0;
  std::uint16_t set = 0;
};

// False: no PGM, cut, or not exactly the buffer's size. Samples above 8 bits lose their low bits.
[[nodiscard]] bool read_pgm(const std::string& file, const GrayBuffer& to, PgmSamples& samples) noexcept;

// 8 bits. False, and errno says why, when it cannot be written whole.
[[nodiscard]] bool write_pgm(const std::string& file, const GrayView& image);

}  // namespace srd
