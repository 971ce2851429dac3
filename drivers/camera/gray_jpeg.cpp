// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/gray_jpeg.hpp"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <vector>

// After <cstdio>, which it wants.
#include <jpeglib.h>

#include <jerror.h>

namespace srd {

namespace {

constexpr std::size_t kAlignment = 64;  // bytes; libjpeg's vector code wants 32
// Tables and bookkeeping, then rows of blocks: 24 bytes a column with 4:2:0, none of them of an upsampler.
constexpr std::size_t kFixedBytes = std::size_t{256} << 10, kBytesAColumn = 96;
constexpr std::array<JOCTET, 2> kEndOfImage{0xFF, JPEG_EOI};

std::size_t rounded(std::size_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

}  // namespace

// libjpeg leaves by longjmp: the functions between its entries and the setjmp own nothing that a destructor would have to free.
struct GrayJpegDecoder::State {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_source_mgr source{};
  jmp_buf out{};
  std::vector<std::uint8_t> block;
  std::size_t at = 0, most = 0;
  int width = 0, height = 0;
  bool damaged = false;

  static State& of(j_common_ptr jpeg) { return *static_cast<State*>(jpeg->client_data); }
  static State& of(j_decompress_ptr jpeg) { return *static_cast<State*>(jpeg->client_data); }

  [[noreturn]] static void leave(j_common_ptr jpeg) { std::longjmp(of(jpeg).out, 1); }  // NOLINT: libjpeg's way
  // Negative: it goes on with what it guesses.
  static void note(j_common_ptr jpeg, int level) {
    if (level < 0) of(jpeg).damaged = true;
  }

  // The memory: each image from the block's beginning. Images that need arrays of their whole size (several scans) are refused
  // before these are asked for.
  void* take(std::size_t bytes) {
    const std::size_t size = rounded(bytes);
    if (size < bytes || size > block.size() - kAlignment - at) leave(reinterpret_cast<j_common_ptr>(&jpeg));
    const std::size_t first = kAlignment - reinterpret_cast<std::uintptr_t>(block.data()) % kAlignment;
    std::uint8_t* memory = block.data() + first + at;
    at += size;
    most = std::max(most, at);
    return memory;
  }
  static void* alloc(j_common_ptr jpeg, int, std::size_t bytes) { return of(jpeg).take(bytes); }
  template <class Row, class Element>
  static Row* alloc_rows(j_common_ptr jpeg, std::size_t across, JDIMENSION rows) {
    State& state = of(jpeg);
    auto* list = static_cast<Row*>(state.take(rows * sizeof(Row)));
    for (JDIMENSION row = 0; row < rows; ++row) list[row] = static_cast<Element*>(state.take(across * sizeof(Element)));
    return list;
  }
  static JSAMPARRAY alloc_samples(j_common_ptr jpeg, int, JDIMENSION across, JDIMENSION rows) {
    return alloc_rows<JSAMPROW, JSAMPLE>(jpeg, across, rows);
  }
  static JBLOCKARRAY alloc_blocks(j_common_ptr jpeg, int, JDIMENSION across, JDIMENSION rows) {
    return alloc_rows<JBLOCKROW, JBLOCK>(jpeg, across, rows);
  }
  static jvirt_sarray_ptr no_samples(j_common_ptr jpeg, int, boolean, JDIMENSION, JDIMENSION, JDIMENSION) { leave(jpeg); }
  static jvirt_barray_ptr no_blocks(j_common_ptr jpeg, int, boolean, JDIMENSION, JDIMENSION, JDIMENSION) { leave(jpeg); }
  static void free_pool(j_common_ptr jpeg, int) { of(jpeg).at = 0; }

  // The bytes: all at once. Where they end before the image does, it is damaged.
  static void nothing(j_decompress_ptr) {}
  static boolean end_it(j_decompress_ptr jpeg) {
    of(jpeg).damaged = true;
    jpeg->src->next_input_byte = kEndOfImage.data();
    jpeg->src->bytes_in_buffer = kEndOfImage.size();
    return TRUE;
  }
  static void skip(j_decompress_ptr jpeg, long bytes) {
    if (bytes <= 0) return;
    const auto size = static_cast<std::size_t>(bytes);
    if (size > jpeg->src->bytes_in_buffer) {
      static_cast<void>(end_it(jpeg));
      return;
    }
    jpeg->src->next_input_byte += size;
    jpeg->src->bytes_in_buffer -= size;
  }

  State(int image_width, int image_height) : width(image_width), height(image_height) {
    block.resize(kFixedBytes + kBytesAColumn * static_cast<std::size_t>(width) + kAlignment);  // touched: no page comes late
    jpeg.err = jpeg_std_error(&errors);
    errors.error_exit = leave;
    errors.emit_message = note;
    errors.output_message = [](j_common_ptr) {};
    jpeg.client_data = this;
    if (setjmp(out) != 0) return;  // NOLINT: libjpeg's way; an object without a manager decodes nothing
    jpeg_create_decompress(&jpeg);
    source.init_source = nothing;
    source.fill_input_buffer = end_it;
    source.skip_input_data = skip;
    source.resync_to_restart = jpeg_resync_to_restart;
    source.term_source = nothing;
    jpeg.src = &source;
    // What it made for itself until here is of its own manager, whose self_destruct frees it.
    jpeg_memory_mgr& memory = *jpeg.mem;
    memory.alloc_small = alloc;
    memory.alloc_large = alloc;
    memory.alloc_sarray = alloc_samples;
    memory.alloc_barray = alloc_blocks;
    memory.request_virt_sarray = no_samples;
    memory.request_virt_barray = no_blocks;
    memory.free_pool = free_pool;
  }
  ~State() { jpeg_destroy_decompress(&jpeg); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  [[nodiscard]] bool fits() const {
    if (static_cast<int>(jpeg.image_width) != width || static_cast<int>(jpeg.image_height) != height) return false;
    if (jpeg.progressive_mode != 0 || jpeg.arith_code != 0 || jpeg.comps_in_scan != jpeg.num_components) return false;
    if (jpeg.jpeg_color_space != JCS_GRAYSCALE && jpeg.jpeg_color_space != JCS_YCbCr) return false;
    const jpeg_component_info& luma = jpeg.comp_info[0];  // brightness at half of the pixels is none
    return luma.h_samp_factor == jpeg.max_h_samp_factor && luma.v_samp_factor == jpeg.max_v_samp_factor;
  }

  bool decode(std::span<const std::uint8_t> bytes, std::uint8_t* to, int to_stride) {
    if (jpeg.mem == nullptr) return false;
    damaged = false;
    if (setjmp(out) != 0) {  // NOLINT: libjpeg's way
      jpeg_abort_decompress(&jpeg);
      return false;
    }
    source.next_input_byte = bytes.data();
    source.bytes_in_buffer = bytes.size();
    // Tables of the image before lie in memory that this one takes.
    at = 0;
    std::fill(std::begin(jpeg.quant_tbl_ptrs), std::end(jpeg.quant_tbl_ptrs), nullptr);
    std::fill(std::begin(jpeg.dc_huff_tbl_ptrs), std::end(jpeg.dc_huff_tbl_ptrs), nullptr);
    std::fill(std::begin(jpeg.ac_huff_tbl_ptrs), std::end(jpeg.ac_huff_tbl_ptrs), nullptr);
    bool good = jpeg_read_header(&jpeg, TRUE) == JPEG_HEADER_OK && fits();
    if (good) {
      jpeg.out_color_space = JCS_GRAYSCALE;
      jpeg.dct_method = JDCT_ISLOW;
      jpeg.do_fancy_upsampling = FALSE;
      jpeg.do_block_smoothing = FALSE;
      good = jpeg_start_decompress(&jpeg) != 0;
    }
    while (good && jpeg.output_scanline < jpeg.output_height) {
      JSAMPROW row = to + static_cast<std::ptrdiff_t>(jpeg.output_scanline) * to_stride;
      good = jpeg_read_scanlines(&jpeg, &row, 1) == 1;
    }
    good = good && jpeg_finish_decompress(&jpeg) != 0;
    if (!good) jpeg_abort_decompress(&jpeg);
    return good && !damaged;
  }
};

GrayJpegDecoder::GrayJpegDecoder(int width, int height) : state_(std::make_unique<State>(width, height)) {}
GrayJpegDecoder::~GrayJpegDecoder() = default;

bool GrayJpegDecoder::decode(std::span<const std::uint8_t> bytes, std::uint8_t* to, int to_stride) noexcept {
  return state_->decode(bytes, to, to_stride);
}
std::size_t GrayJpegDecoder::used() const noexcept { return state_->most; }
std::size_t GrayJpegDecoder::reserved() const noexcept { return state_->block.size() - kAlignment; }

}  // namespace srd
