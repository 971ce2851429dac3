// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/image_sketch.hpp"

#include <algorithm>
#include <cstdlib>

#include "drivers/support/formatted.hpp"

namespace srd {

namespace {

constexpr int kPairStep = 16;     // rows from one pair to the next
constexpr int kDark = 40;         // grey level that nearly all of a dark image stays below
constexpr int kTwelveBits = 16;   // the upper byte of 12 bits that lie at the lower end of 16 is 0 to 15
constexpr int kMinContrast = 60;  // of the detector's default threshold
constexpr double kMosaic = 1.3, kMosaicLevels = 4;
constexpr double kMaxSaturated = 0.2;
constexpr int kReach = 4;           // px
constexpr int kAround = 14;         // px to either side: there an edge of the worst blur has its whole contrast
constexpr double kSteepest = 0.35;  // a blur of 4.4 px: the corner fit follows up to 4

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
  for (int v = 0; v < image.height; ++v)
    if (v % kPairStep <= 1) take_edges(image.row(v), image.width);
}

// Of each place whose surroundings differ by half of the image's contrast: what of that lies within kReach.
void ImageSketch::take_edges(const std::uint8_t* row, int width) noexcept {
  const int least = std::max((level(990) - level(10)) / 2, 1);
  for (int u = kAround; u + kReach + kAround < width; ++u) {
    int dark = 255, bright = 0;
    for (int k = u - kAround; k <= u + kReach + kAround; k += 2) {
      dark = std::min<int>(dark, row[k]);
      bright = std::max<int>(bright, row[k]);
    }
    if (bright - dark < least) continue;
    ++steps_[static_cast<std::size_t>(std::min(255, 255 * std::abs(row[u] - row[u + kReach]) / (bright - dark)))];
    ++edges_;
  }
}

int ImageSketch::level_of(const Histogram& histogram, std::uint64_t all, int permille) noexcept {
  std::uint64_t below = 0;
  for (int grey = 0; grey < 256; ++grey) {
    below += histogram[static_cast<std::size_t>(grey)];
    if (below * 1000 >= all * static_cast<std::uint64_t>(permille)) return grey;
  }
  return 255;
}

int ImageSketch::level(int permille) const noexcept { return level_of(histogram_, pixels_, permille); }

double ImageSketch::steepest() const noexcept {
  // An edge is in the surroundings of 2 kAround + kReach places of its row and steepest at one of them.
  static_assert(2 * kAround + kReach == 32);
  return level(990) <= level(10) ? 1 : level_of(steps_, edges_, 985) / 255.0;
}

ImageFault ImageSketch::fault() const noexcept {
  if (!taken()) return ImageFault::kNone;
  const int dark = level(10), bright = level(990);
  if (level(1000) < kTwelveBits) return ImageFault::kNearlyBlack;
  if (bright < kDark) return ImageFault::kDark;
  if (static_cast<double>(histogram_[255]) > kMaxSaturated * static_cast<double>(pixels_)) return ImageFault::kSaturated;
  if (neighbours() > kMosaicLevels && neighbours() > kMosaic * second_neighbours()) return ImageFault::kMosaic;
  if (bright - dark < kMinContrast) return ImageFault::kLittleContrast;
  if (steepest() < kSteepest) return ImageFault::kBlurred;
  return ImageFault::kNone;
}

std::string ImageSketch::diagnosis() const {
  if (!taken()) return {};
  const int dark = level(10), bright = level(990);
  const std::string light = "Look at the light, camera.exposure_us, camera.gain and the aperture";
  switch (fault()) {
    case ImageFault::kNearlyBlack:
      return formatted("the image is nearly black: no grey level above %d of 255. ", level(1000)) +
             "Pixels of 10 or 12 bits at the lower end of 16 look so (recordings: camera.bits, --bits of srd reconstruct; "
             "V4L2: "
             "camera.format Y10 or Y12); else the lens cap, the light, camera.exposure_us";
    case ImageFault::kDark:
      return formatted("the image is too dark: 99 %% of it is at or below grey level %d of 255. ", bright) + light;
    case ImageFault::kSaturated:
      return formatted("the image is too bright: %.0f %% of it is saturated (255). ",
                       100 * static_cast<double>(histogram_[255]) / static_cast<double>(pixels_)) +
             light + "; reflections";
    case ImageFault::kMosaic:
      return formatted("neighbouring pixels differ by %.0f grey levels, every second one by %.0f only: ", neighbours(),
                       second_neighbours()) +
             "this is the mosaic of a colour sensor (Bayer) taken for grey. Convert it to grey first, or choose a format that "
             "the camera converts (camera.format)";
    case ImageFault::kLittleContrast:
      return formatted("the image has little contrast: 98 %% of it lies between grey levels %d and %d. ", dark, bright) +
             "Is the pattern in view, in focus, evenly lit?";
    case ImageFault::kBlurred:
      return formatted("the image is blurred: its steepest edges take %.0f %% of their contrast within %d px, sharp ones all. ",
                       100 * steepest(), kReach) +
             "Focus the lens (camera.focus), look for drops and mist on it, shorten the exposure; or is the pattern not in "
             "view?";
    case ImageFault::kNone: break;
  }
  return formatted("the image itself looks sound (grey levels %d to %d). ", dark, bright) +
         "Is the whole pattern in view; are pattern.rows, .columns and .square_mm its own; is the image upside down or "
         "mirrored, "
         "or are black and white swapped (geometry.pose, pattern.first_square); is surface.guess_mm the water's level?";
}

}  // namespace srd
