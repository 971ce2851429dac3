#include "dsp/frontend/corner_tracker.hpp"

#include <algorithm>

namespace srd::dsp {

namespace {

constexpr int kMaxRadius = ResponseWindow::kMostSide / 2;

// The top of a parabola through three responses, Q12 px from the middle one, which is the largest.
std::int32_t parabola_q12(int before, int top, int after) {
  const int bend = 2 * top - before - after;
  return bend > 0 ? ((after - before) << 11) / bend : 0;
}

// A start for the fit, a few tenths of a pixel from the corner.
void place_at(const ResponseWindow& window, const WindowPeak& peak, CornerShape& shape) {
  shape.u = Pixel::from_int(window.u0 + peak.column);
  shape.v = Pixel::from_int(window.v0 + peak.row);
  const int last = window.side - 1;
  if (peak.row == 0 || peak.column == 0 || peak.row == last || peak.column == last) return;
  const std::int16_t* at = window.row(peak.row) + peak.column;
  shape.u = shape.u + Pixel::from_raw(parabola_q12(at[-1], at[0], at[1]));
  shape.v = shape.v + Pixel::from_raw(parabola_q12(at[-ResponseWindow::kStride], at[0], at[ResponseWindow::kStride]));
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
