// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/jpeg_image.hpp"

#include <cstdio>
#include <cstdlib>

// After <cstdio>, which it wants.
#include <jpeglib.h>

namespace srd::fakes {

namespace {

// Without its DHT segments.
std::vector<std::uint8_t> without_huffman_tables(const std::vector<std::uint8_t>& jpeg) {
  std::vector<std::uint8_t> out(jpeg.begin(), jpeg.begin() + 2);
  std::size_t at = 2;
  while (at + 4 <= jpeg.size()) {
    const std::uint8_t marker = jpeg[at + 1];
    const std::size_t end = at + 2 + (static_cast<std::size_t>(jpeg[at + 2]) << 8 | jpeg[at + 3]);
    const bool scan = marker == 0xDA;
    if (marker != 0xC4)
      out.insert(out.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                 scan ? jpeg.end() : jpeg.begin() + static_cast<std::ptrdiff_t>(end));
    if (scan) break;
    at = end;
  }
  return out;
}

}  // namespace

std::vector<std::uint8_t> jpeg_of(const GrayView& image, const JpegKind& kind) {
  jpeg_compress_struct jpeg;
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(image.width);
  jpeg.image_height = static_cast<JDIMENSION>(image.height);
  jpeg.input_components = kind.colour ? 3 : 1;
  jpeg.in_color_space = kind.colour ? JCS_YCbCr : JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, kind.quality, TRUE);
  jpeg.dct_method = JDCT_ISLOW;
  jpeg.restart_in_rows = kind.restart_rows;
  if (kind.colour) jpeg.comp_info[0].v_samp_factor = 1;
  if (kind.progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(image.width * jpeg.input_components));
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const auto at = static_cast<std::size_t>(u * jpeg.input_components);
      row[at] = image.row(v)[u];
      if (kind.colour) {
        row[at + 1] = 110;
        row[at + 2] = static_cast<std::uint8_t>(100 + (u + v) % 64);
      }
    }
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&jpeg, &rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::vector<std::uint8_t> made(bytes, bytes + size);
  jpeg_destroy_compress(&jpeg);
  std::free(bytes);
  return kind.tables ? made : without_huffman_tables(made);
}

}  // namespace srd::fakes
