// SPDX-License-Identifier: Apache-2.0
// JPEG images as cameras send them, made by libjpeg.
#pragma once

#include <cstdint>
#include <vector>

#include "dsp/core/image_view.hpp"

namespace srd::fakes {

struct JpegKind {
  int quality = 85;
  bool colour = true;        // YCbCr with half of the colour's columns (4:2:2), all of one colour; else grey
  bool tables = true;        // false: the standard's Huffman tables are left out, as most cameras do
  bool progressive = false;  // several scans: no camera's
  int restart_rows = 0;      // rows of blocks between restart markers
};

[[nodiscard]] std::vector<std::uint8_t> jpeg_of(const GrayView& image, const JpegKind& kind = {});

}  // namespace srd::fakes
