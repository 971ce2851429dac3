// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator/unsharp_mask.hpp"

#include <algorithm>
#include <cassert>

#include "drivers/camera/simulator/stable_math.hpp"

namespace srd {

namespace {

constexpr double kReach = 4;  // standard deviations
constexpr int kWeightBits = 14;

}  // namespace

UnsharpMask::UnsharpMask(double amount, double radius_px, int width, int height)
    : width_(static_cast<std::size_t>(width)),
      height_(static_cast<std::size_t>(height)),
      amount_q12_(static_cast<std::int32_t>(amount * 4096 + 0.5)),
      levels_(width_ * height_),
      across_(width_ * height_) {
  const int reach = static_cast<int>(kReach * radius_px + 0.999);
  std::vector<double> weights;
  double sum = 0;
  for (int k = 0; k <= reach; ++k) {
    weights.push_back(stable::exp_negative(-0.5 * k * k / (radius_px * radius_px)));
    sum += (k == 0 ? 1 : 2) * weights.back();
  }
  // The middle takes what rounding leaves, so that an even grey stays what it is.
  std::int32_t rest = 1 << kWeightBits;
  for (const double weight : weights)
    weights_q14_.push_back(static_cast<std::int32_t>(weight / sum * (1 << kWeightBits) + 0.5));
  for (std::size_t k = 1; k < weights_q14_.size(); ++k) rest -= 2 * weights_q14_[k];
  weights_q14_[0] = rest;
  padded_.resize(width_ + 2 * weights_q14_.size());
}

void UnsharpMask::finish(const GrayBuffer& image) {
  assert(static_cast<std::size_t>(image.width) == width_ && static_cast<std::size_t>(image.height) == height_);
  // |sum| <= 2^14 * 255 * 2^8 < 2^30: int32 has a bit to spare.
  constexpr std::int32_t kHalf = 1 << (kWeightBits - 1);
  const std::size_t reach = weights_q14_.size() - 1;
  for (std::size_t v = 0; v < height_; ++v) {
    const std::int32_t* from = levels_.data() + v * width_;
    std::fill_n(padded_.begin(), reach, from[0]);
    std::copy_n(from, width_, padded_.begin() + static_cast<std::ptrdiff_t>(reach));
    std::fill_n(padded_.begin() + static_cast<std::ptrdiff_t>(reach + width_), reach, from[width_ - 1]);
    std::int32_t* to = across_.data() + v * width_;
    for (std::size_t u = 0; u < width_; ++u) {
      const std::int32_t* at = padded_.data() + reach + u;
      std::int32_t sum = kHalf + weights_q14_[0] * at[0];
      for (std::size_t k = 1; k <= reach; ++k) sum += weights_q14_[k] * (*(at - k) + at[k]);
      to[u] = sum >> kWeightBits;
    }
  }
  const auto last = static_cast<std::ptrdiff_t>(height_) - 1;
  for (std::ptrdiff_t v = 0; v <= last; ++v) {
    std::int32_t* sums = padded_.data();
    const auto across = [&](std::ptrdiff_t row) { return across_.data() + static_cast<std::size_t>(row) * width_; };
    const std::int32_t* middle = across(v);
    for (std::size_t u = 0; u < width_; ++u) sums[u] = kHalf + weights_q14_[0] * middle[u];
    for (std::size_t k = 1; k <= reach; ++k) {
      const auto step = static_cast<std::ptrdiff_t>(k);
      const std::int32_t *above = across(std::max<std::ptrdiff_t>(v - step, 0)), *below = across(std::min(v + step, last));
      for (std::size_t u = 0; u < width_; ++u) sums[u] += weights_q14_[k] * (above[u] + below[u]);
    }
    const std::int32_t* sharp = levels_.data() + static_cast<std::size_t>(v) * width_;
    std::uint8_t* to = image.pixels + static_cast<std::int64_t>(v) * image.stride_bytes;
    for (std::size_t u = 0; u < width_; ++u) {
      // |level - blurred| <= 255 * 2^8 < 2^16, the amount at most 3 * 2^12 < 2^14: int32 has a bit to spare.
      const std::int32_t level = sharp[u] + ((amount_q12_ * (sharp[u] - (sums[u] >> kWeightBits))) >> 12);
      to[u] = static_cast<std::uint8_t>(std::clamp((level + 128) >> 8, 0, 255));
    }
  }
}

}  // namespace srd
