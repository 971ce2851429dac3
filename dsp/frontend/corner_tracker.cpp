// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/corner_tracker.hpp"

#include <algorithm>

#include "dsp/frontend/response_top.hpp"

namespace srd::dsp {

namespace {

constexpr int kMaxRadius = ResponseWindow::kMaxSide / 2;

}  // namespace

void prefetch_window(const GrayView& image, int u, int v, int half) {
  if (!image.contains(u, v, half)) return;
  for (int row = v - half; row <= v + half; ++row) {
    __builtin_prefetch(image.row(row) + u - half);
    __builtin_prefetch(image.row(row) + u + half);
  }
}

Tracked track_corner(const GrayView& image, const Region& region, const CornerShape& expected, int search_radius,
                     const TrackOptions& options, CornerFit& fit) {
  const int r = std::clamp(search_radius, 1, kMaxRadius);
  const int cu = expected.u.round(), cv = expected.v.round();
  const int margin = r + std::max(options.response.radius, options.fit.half_window);
  if (!image.contains(cu, cv, margin)) return Tracked::kOutside;
  if (!region.empty() && (cu < region.u0 || cv < region.v0 || cu >= region.u1 || cv >= region.v1)) return Tracked::kOutside;

  ResponseWindow window;
  response_window(image, cu - r, cv - r, 2 * r + 1, options.response, window);
  const WindowPeak peak = window_peak(window, static_cast<std::int16_t>(options.threshold));
  if (peak.response <= options.threshold) return Tracked::kNone;
  if (peak.another) return Tracked::kAmbiguous;
  CornerShape start = expected;
  start.u = Pixel::from_int(window.u0 + peak.column);
  start.v = Pixel::from_int(window.v0 + peak.row);
  (void)place_at_top(window, peak.row, peak.column, start);
  if (!fit_corner(image, start, options.fit, fit)) return Tracked::kRejected;
  const std::int64_t du = fit.corner.u.raw() - expected.u.raw(), dv = fit.corner.v.raw() - expected.v.raw();
  const std::int64_t limit = static_cast<std::int64_t>(r) << Pixel::kFractionBits;
  if (du * du + dv * dv > limit * limit) return Tracked::kRejected;
  fit.corner.response = peak.response;
  return Tracked::kFound;
}

}  // namespace srd::dsp
