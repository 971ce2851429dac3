// SPDX-License-Identifier: Apache-2.0
// One corner near where it is expected. Integer arithmetic, stateless, cost independent of the image's size.
#pragma once

#include "dsp/frontend/chess_response.hpp"
#include "dsp/frontend/corner_fit.hpp"

namespace srd::dsp {

struct TrackOptions {
  ResponseOptions response;
  int threshold = 200;  // least response of a strong maximum
  CornerFitOptions fit;
};

enum class Tracked : std::uint8_t {
  kFound,
  kOutside,    // the window leaves the image or the region
  kNone,       // no strong maximum within the radius: hidden, or not there
  kAmbiguous,  // two strong maxima: which is ours cannot be told
  kRejected,   // a maximum, but no corner of the expected polarity and quality (glare, an edge of the board)
};

// Asks for the pixels that track_corner will read round (u, v), while another corner is worked on: a frame that has just
// come from the camera is in no cache.
void prefetch_window(const GrayView& image, int u, int v, int half);

// expected: where the corner should be, the normals of its edges with the expected polarity, its blur.
// search_radius: px, 1..15; the corner found lies within it.
[[nodiscard]] Tracked track_corner(const GrayView& image, const Region& region, const CornerShape& expected, int search_radius,
                                   const TrackOptions& options, CornerFit& fit);

}  // namespace srd::dsp
