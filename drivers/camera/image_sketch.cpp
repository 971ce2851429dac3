// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/image_sketch.hpp"

#include <algorithm>
#include <cstdlib>

#include "drivers/support/formatted.hpp"

namespace srd {

namespace {

constexpr int kPairStep = 16;       // rows from one pair to the next
constexpr int kDark = 40;           // grey level that nearly all of a dark image stays below
constexpr int kTwelveBits = 16;     // the upper byte of 12 bits that lie at the lower end of 16 is 0 to 15
constexpr int kLeastContrast = 60;  // of the detector's default threshold
constexpr double kMosaic = 1.3, kMosaicLevels = 4;

}  // namespace

ImageSketch::ImageSketch(const GrayView& image) noexcept {
  for (int v = 0; v < image.height; ++v) {
    if (v % kPairStep > 1) continue;
    const std::uint8_t* row = image.row(v);
    for (int u = 0; u + 2 < image.width; ++u) {
      ++histogram_[row[u]];
      next_ += static_cast<std::uint64_t>(std::abs(row[u] - row[u + 1]));
      second_ += static_cast<std::uint64_t>(std::abs(row[u] - row[u + 2]));
      ++pixels_;
    }
  }
}

int ImageSketch::level(int permille) const noexcept {
  std::uint64_t below = 0;
  for (int grey = 0; grey < 256; ++grey) {
    below += histogram_[static_cast<std::size_t>(grey)];
    if (below * 1000 >= pixels_ * static_cast<std::uint64_t>(permille)) return grey;
  }
  return 255;
}

std::string ImageSketch::diagnosis() const {
  if (!taken()) return {};
  const int dark = level(10), bright = level(990), brightest = level(1000);
  const double saturated = static_cast<double>(histogram_[255]) / static_cast<double>(pixels_);
  if (brightest < kTwelveBits)
    return formatted(
        "the image is nearly black: no grey level above %d of 255. Pixels of 10 or 12 bits at the lower end of 16 look "
        "so (files: shift them up or save 8 bits; V4L2: camera.format Y10 or Y12); else the lens cap, the light, "
        "camera.exposure_us",
        brightest);
  if (bright < kDark)
    return formatted(
        "the image is too dark: 99 %% of it is at or below grey level %d of 255. Look at the light, camera.exposure_us, "
        "camera.gain and the aperture",
        bright);
  if (saturated > 0.2)
    return formatted("%.0f %% of the image is saturated (255). Look at camera.exposure_us, camera.gain, reflections",
                     100 * saturated);
  if (neighbours() > kMosaicLevels && neighbours() > kMosaic * second_neighbours())
    return formatted(
        "neighbouring pixels differ by %.0f grey levels, every second one by %.0f only: this is the mosaic of a colour "
        "sensor taken for grey. Convert it to grey first, or choose a format that the camera converts (camera.format)",
        neighbours(), second_neighbours());
  if (bright - dark < kLeastContrast)
    return formatted(
        "the image has little contrast: 98 %% of it lies between grey levels %d and %d. Is the pattern in view, in focus, "
        "evenly lit?",
        dark, bright);
  return formatted(
      "the image itself looks sound (grey levels %d to %d). Is the whole pattern in view and in focus; are pattern.rows, "
      ".columns and .square_mm its own; is the image upside down or mirrored, or are black and white swapped "
      "(geometry.pose, pattern.first_square); is surface.guess_mm the water's level?",
      dark, bright);
}

}  // namespace srd
