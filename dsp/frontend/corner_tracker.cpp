#include "dsp/frontend/corner_tracker.hpp"

#include <algorithm>
#include <cstdlib>

namespace srd::dsp {

namespace {

constexpr int kMaxRadius = ResponseWindow::kMostSide / 2;

// A start for the fit: the top of the paraboloid through the 5x5 responses round the peak, by least squares. A few
// hundredths of a pixel from the corner, so that one step of the fit is most often enough.
void place_at(const ResponseWindow& window, const WindowPeak& peak, CornerShape& shape) {
  shape.u = Pixel::from_int(window.u0 + peak.column);
  shape.v = Pixel::from_int(window.v0 + peak.row);
  const int last = window.side - 1;
  if (std::min(peak.row, peak.column) < 2 || std::max(peak.row, peak.column) > last - 2) return;
  // Sums of |response| <= 2040 with weights up to 4 over 25 places: < 2^18.
  std::int64_t sum = 0, u = 0, v = 0, uu = 0, vv = 0, uv = 0;
  for (int i = -2; i <= 2; ++i) {
    const std::int16_t* at = window.row(peak.row + i) + peak.column;
    const int row = at[-2] + at[-1] + at[0] + at[1] + at[2], slope = 2 * (at[2] - at[-2]) + at[1] - at[-1];
    sum += row;
    u += slope;
    uu += 4 * (at[2] + at[-2]) + at[1] + at[-1];
    v += i * row;
    vv += i * i * row;
    uv += i * slope;
  }
  // Gradient and curvatures, both times 700; the normal equations of the paraboloid are diagonal but for the constant.
  const std::int64_t bend_u = 20 * (uu - 2 * sum), bend_v = 20 * (vv - 2 * sum), twist = 7 * uv;
  const std::int64_t det = bend_u * bend_v - twist * twist;
  if (bend_u >= 0 || det <= 0) return;
  const std::int64_t du = ((twist * v - bend_v * u) * 14 << 12) / det, dv = ((twist * u - bend_u * v) * 14 << 12) / det;
  if (std::max(std::abs(du), std::abs(dv)) > Pixel::kOne) return;
  shape.u = shape.u + Pixel::from_raw(static_cast<std::int32_t>(du));
  shape.v = shape.v + Pixel::from_raw(static_cast<std::int32_t>(dv));
}

}  // namespace

Tracked track_corner(const GrayView& image, const Region& region, const CornerShape& expected, int search_radius,
                     const TrackOptions& options, CornerFit& fit) {
  const int r = std::clamp(search_radius, 1, kMaxRadius);
  const int cu = expected.u.round(), cv = expected.v.round();
  const int margin = r + std::max(options.response.radius, options.fit.half_window);
  if (!image.contains(cu, cv, margin)) return Tracked::kOutside;
  if (!region.empty() && (cu < region.u0 || cv < region.v0 || cu >= region.u1 || cv >= region.v1))
    return Tracked::kOutside;

  ResponseWindow window;
  response_window(image, cu - r, cv - r, 2 * r + 1, options.response, window);
  const WindowPeak peak = window_peak(window, static_cast<std::int16_t>(options.threshold));
  if (peak.response <= options.threshold) return Tracked::kNone;
  if (peak.another) return Tracked::kAmbiguous;
  CornerShape start = expected;
  place_at(window, peak, start);
  if (!fit_corner(image, start, options.fit, fit)) return Tracked::kRejected;
  const std::int64_t du = fit.corner.u.raw() - expected.u.raw(), dv = fit.corner.v.raw() - expected.v.raw();
  const std::int64_t limit = static_cast<std::int64_t>(r) << Pixel::kFractionBits;
  if (du * du + dv * dv > limit * limit) return Tracked::kRejected;
  fit.corner.response = peak.response;
  return Tracked::kFound;
}

}  // namespace srd::dsp
