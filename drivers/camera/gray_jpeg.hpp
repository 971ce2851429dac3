// SPDX-License-Identifier: Apache-2.0
// The frames of a camera that sends each one as a JPEG (UVC's MJPG): their brightness, decoded by libjpeg-turbo.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

namespace srd {

// Whole baseline images (one scan, as cameras make them) of one size, in YCbCr or grey; the colour is read over. Tables that a
// frame leaves out are the standard's. libjpeg's memory comes from a block that the object reserves at construction, so decode
// takes nothing from the heap: an image that would need more of it is refused. Frames do not depend on each other.
// One thread per object.
class GrayJpegDecoder {
 public:
  GrayJpegDecoder(int width, int height);  // px
  ~GrayJpegDecoder();
  GrayJpegDecoder(const GrayJpegDecoder&) = delete;
  GrayJpegDecoder& operator=(const GrayJpegDecoder&) = delete;

  // Fills width x height pixels. False: not such an image, or not whole: cut, or with bytes that the decoder has to skip or
  // guess, which is how lost packets show. The pixels are then of no use. What follows the image's end is ignored.
  [[nodiscard]] bool decode(std::span<const std::uint8_t> bytes, std::uint8_t* to, int to_stride) noexcept;

  // Of the block, the most that an image has taken so far, and its size, bytes.
  [[nodiscard]] std::size_t used() const noexcept;
  [[nodiscard]] std::size_t reserved() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace srd
