#include "dsp/frontend/corner_tracker.hpp"

#include <algorithm>
#include <array>

namespace srd::dsp {

namespace {

constexpr int kMaxRadius = 15;
constexpr int kSide = 2 * kMaxRadius + 1;

struct Peak {
  int u = 0, v = 0;
  std::int16_t response = -32768;
};

}  // namespace

Tracked track_corner(const GrayView& image, const Region& region, const CornerShape& expected, int search_radius,
                     const TrackOptions& options, CornerFit& fit) {
  const int r = std::clamp(search_radius, 1, kMaxRadius);
  const int cu = expected.u.round(), cv = expected.v.round();
  const int margin = r + std::max(options.response.radius, options.fit.half_window);
  if (!image.contains(cu, cv, margin)) return Tracked::kOutside;
  if (!region.empty() && (cu < region.u0 || cv < region.v0 || cu >= region.u1 || cv >= region.v1))
    return Tracked::kOutside;

  const int side = 2 * r + 1;
  std::array<std::int16_t, kSide * kSide> responses;
  Peak best;
  for (int row = 0; row < side; ++row) {
    std::int16_t* out = responses.data() + row * side;
    response_row(image, cv - r + row, cu - r, cu + r + 1, options.response, out);
    for (int column = 0; column < side; ++column)
      if (out[column] > best.response) best = {cu - r + column, cv - r + row, out[column]};
  }
  if (best.response <= options.threshold) return Tracked::kNone;
  // A second local maximum at least half as strong, further off than the first one's own plateau, makes it a guess.
  constexpr int kPlateau = 4;
  for (int row = 1; row + 1 < side; ++row)
    for (int column = 1; column + 1 < side; ++column) {
      const std::int16_t* at = responses.data() + row * side + column;
      if (at[0] <= options.threshold || 2 * at[0] < best.response) continue;
      if (std::max(std::abs(cu - r + column - best.u), std::abs(cv - r + row - best.v)) <= kPlateau) continue;
      if (at[0] >= at[-1] && at[0] >= at[1] && at[0] >= at[-side] && at[0] >= at[side]) return Tracked::kAmbiguous;
    }

  CornerShape start = expected;
  start.u = Pixel::from_int(best.u);
  start.v = Pixel::from_int(best.v);
  if (!fit_corner(image, start, options.fit, fit)) return Tracked::kRejected;
  const std::int64_t du = fit.corner.u.raw() - expected.u.raw(), dv = fit.corner.v.raw() - expected.v.raw();
  const std::int64_t limit = static_cast<std::int64_t>(r) << Pixel::kFractionBits;
  if (du * du + dv * dv > limit * limit) return Tracked::kRejected;
  fit.corner.response = best.response;
  return Tracked::kFound;
}

}  // namespace srd::dsp
