#include "dsp/frontend/sharpening.hpp"

#include <algorithm>
#include <array>

namespace srd::dsp {

namespace {

// What the model leaves of the starts' corners, squares of the residual over the contrast, Q24. A start that gives no corner
// counts as much as the worst that would be one.
std::int64_t left_over(const GrayView& image, std::span<const CornerShape> starts, const CornerFitOptions& options) {
  const std::int64_t worst = (options.max_residual_percent << 12) / 100;
  std::int64_t sum = 0;
  for (const CornerShape& start : starts) {
    CornerFit fit;
    std::int64_t part = worst;
    if (fit_corner(image, start, options, fit))
      part = std::min<std::int64_t>(fit.residual_q6 * 64 / std::max<int>(fit.corner.contrast, 1), worst);
    sum += part * part;
  }
  return sum;
}

}  // namespace

Sharpening measure_sharpening(const GrayView& image, std::span<const CornerShape> starts, const CornerFitOptions& options) {
  CornerFitOptions trial = options;
  trial.sharpening = {};
  const std::int64_t without = left_over(image, starts, trial);
  Sharpening best;
  std::int64_t least = without;
  const auto attempt = [&](std::int32_t amount_q12, std::int32_t radius_q12) {
    trial.sharpening = {std::clamp(amount_q12, 0, Sharpening::kMostAmountQ12), std::clamp(radius_q12, 2048, 4 * 4096)};
    const std::int64_t left = left_over(image, starts, trial);
    if (left >= least) return;
    least = left;
    best = trial.sharpening;
  };
  constexpr std::array<std::int32_t, 4> kAmounts{4096 * 3 / 10, 4096 * 7 / 10, 4096 * 13 / 10, 4096 * 22 / 10};
  for (const std::int32_t amount : kAmounts) attempt(amount, 4096);
  if (best.amount_q12 == 0) attempt(4096 / 2, 2 * 4096);
  if (best.amount_q12 == 0) return {};
  // From there along one and the other, in steps that shrink.
  for (const std::int32_t radius : {2867, 5734, 8192}) attempt(best.amount_q12, radius);
  for (const int percent : {25, 12, 6}) {
    const Sharpening from = best;
    attempt(from.amount_q12 * (100 + percent) / 100, from.radius_q12);
    attempt(from.amount_q12 * (100 - percent) / 100, from.radius_q12);
    const Sharpening now = best;
    attempt(now.amount_q12, now.radius_q12 * (100 + percent) / 100);
    attempt(now.amount_q12, now.radius_q12 * (100 - percent) / 100);
  }
  // A print's own faults are explained a little by anything.
  constexpr int kLeastGainPercent = 5;
  return least * 100 > without * (100 - kLeastGainPercent) ? Sharpening{} : best;
}

}  // namespace srd::dsp
