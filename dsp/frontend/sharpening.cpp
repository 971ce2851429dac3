// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/sharpening.hpp"

#include <algorithm>
#include <array>

namespace srd::dsp {

namespace {

constexpr std::size_t kMaxStarts = 64;

// What the model leaves of the better three quarters of the starts' corners: squares of the residual over the contrast, Q24. A
// start that gives no corner counts as much as the worst that would be one. of_all: the same of all starts.
std::int64_t left_over(const GrayView& image, std::span<const CornerShape> starts, const CornerFitOptions& options,
                       std::int64_t& of_all) {
  const std::int64_t worst = (options.max_residual_percent << 12) / 100;
  std::array<std::int64_t, kMaxStarts> parts{};
  std::size_t n = 0;
  for (const CornerShape& start : starts) {
    CornerFit fit;
    std::int64_t part = worst;
    if (fit_corner(image, start, options, fit))
      part = std::min<std::int64_t>(fit.residual_q6 * 64 / std::max<int>(fit.corner.contrast, 1), worst);
    parts[n++] = part * part;
  }
  std::sort(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(n));
  std::int64_t sum = 0;
  of_all = 0;
  for (std::size_t i = 0; i < n; ++i) {
    of_all += parts[i];
    if (i < (3 * n + 3) / 4) sum += parts[i];
  }
  return sum;
}

}  // namespace

Sharpening measure_sharpening(const GrayView& image, std::span<const CornerShape> starts, const CornerFitOptions& options) {
  starts = starts.first(std::min(starts.size(), kMaxStarts));
  CornerFitOptions trial = options;
  trial.sharpening = {};
  std::int64_t without_all = 0, least_all = 0;
  const std::int64_t without = left_over(image, starts, trial, without_all);
  Sharpening best;
  std::int64_t least = without;
  const auto attempt = [&](std::int32_t amount_q12, std::int32_t radius_q12) {
    trial.sharpening = {std::clamp(amount_q12, 0, Sharpening::kMostAmountQ12), std::clamp(radius_q12, 2048, 4 * 4096)};
    std::int64_t all = 0;
    const std::int64_t left = left_over(image, starts, trial, all);
    if (left >= least) return;
    least = left;
    least_all = all;
    best = trial.sharpening;
  };
  constexpr std::array<std::int32_t, 4> kAmounts{4096 * 3 / 10, 4096 * 6 / 10, 4096 * 11 / 10, 4096 * 18 / 10};
  for (const std::int32_t amount : kAmounts) attempt(amount, 4096);
  if (best.amount_q12 == 0) attempt(4096 / 2, 2 * 4096);
  if (best.amount_q12 == 0) return {};
  for (const std::int32_t radius : {2867, 5734, 8192})
    for (const std::int32_t amount : kAmounts) attempt(amount, radius);
  // From the best of these along the valley, in which a larger radius wants a smaller amount, and across it.
  for (const int percent : {20, 10, 5}) {
    for (int again = 0; again < 5; ++again) {
      const Sharpening from = best;
      const auto step = [&](int of_amount, int of_radius) {
        attempt(from.amount_q12 * (100 + of_amount) / 100, from.radius_q12 * (100 + of_radius) / 100);
      };
      step(percent, 0);
      step(-percent, 0);
      step(percent, -percent);
      step(-percent, percent);
      step(-2 * percent, percent);
      step(0, percent);
      step(0, -percent);
      if (best == from) break;
    }
  }
  // A print's own faults are explained a little by anything. Corners that do not fit at all without it speak for it, too.
  constexpr int kMinGainPercent = 5;
  const bool explains = least * 100 <= without * (100 - kMinGainPercent);
  const bool finds = least_all * 100 <= without_all * (100 - kMinGainPercent);
  return explains || finds ? best : Sharpening{};
}

}  // namespace srd::dsp
