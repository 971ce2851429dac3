// SPDX-License-Identifier: Apache-2.0
// A checkerboard corner located to a hundredth of a pixel: least squares of a blurred crossing of two edges on the grey
// levels round it. Integer arithmetic throughout, so every machine gives the same corner.
//
// Model: I(x) = m + c [E(s1) E(s2) + rho D(s1) D(s2)], s_i = n_i.(x - q) / blur, rho = n1.n2, E and D of EdgeProfile, which
// know the lens's blur and the pixel's area. The rho term is the first order of the exact bivariate normal for edges that are
// not perpendicular in the image. What a camera's unsharp mask adds is in the bracket too: corner_sums.hpp. Edges with less
// blur than 0.45 px, lens and pixel together, or 0.6 px and sharpened, have a model of their own: sharp_corner.hpp.
// Seven unknowns: q (2), the turn of each edge, m, c, blur. The model is symmetric about q, so what it leaves out
// (saturation, higher orders of skew) blurs the levels but does not move the corner.
// Lower bound of any estimator: optics (20).
#pragma once

#include <cstdint>

#include "dsp/core/image_view.hpp"
#include "dsp/frontend/corner.hpp"

namespace srd::dsp {

// A direction in the image, Q14, unit length.
struct Direction {
  std::int32_t x = 0, y = 0;
};

// What the fit starts from and improves.
struct CornerShape {
  Pixel u, v;
  Direction n1, n2;              // normals of the two edges; the sectors where both distances have one sign are bright
  std::int32_t blur_q12 = 4096;  // standard deviation of the edges before sharpening, lens and pixel together, px
};

// How the camera has sharpened its image: I + amount (I - G * I), G a Gaussian of this radius (standard deviation).
struct Sharpening {
  static constexpr std::int32_t kMostAmountQ12 = 3 * 4096;
  std::int32_t amount_q12 = 0;     // 0: not at all .. kMostAmountQ12
  std::int32_t radius_q12 = 4096;  // px
  [[nodiscard]] bool operator==(const Sharpening&) const = default;
};

struct CornerFitOptions {
  int half_window = 5;  // px, 3..8, and up to 8/5 of it at 2.8 blurs of the start; the next edge should lie w + 2 blur away
  int max_iterations = 12;
  int min_contrast = 8;           // half difference of bright and dark, grey levels
  int max_residual_percent = 35;  // rms of the residual against the contrast
  int max_travel_q12 = 3 * 4096;  // how far the corner may lie from the start, px
  Sharpening sharpening;
  bool compare_rows = false;  // fill CornerFit::rows_apart
};

struct CornerFit {
  Corner corner;  // u, v, sigma, mean, contrast
  CornerShape shape;
  std::int32_t residual_q6 = 0;  // rms of the fit, grey levels
  int iterations = 0;
  // With compare_rows: how surely even and odd rows show the corner in two places, as the two moments of an interlaced picture
  // do: chi-square of 2 degrees of freedom. 0: not compared.
  float rows_apart = 0;
};

// Two edges through the 16 samples of the circle of this radius (5 or 10) round (u, v): a start for the fit.
// False: not exactly four changes between bright and dark, as at an edge, in a flat area, or at noise.
[[nodiscard]] bool guess_shape(const GrayView& image, int u, int v, int radius, CornerShape& shape);

// False: the window leaves the image, contrast, blur or residual is out of bounds, the edges are nearly parallel,
// or the iteration runs away. Then there is no corner that one would want to measure with.
[[nodiscard]] bool fit_corner(const GrayView& image, const CornerShape& start, const CornerFitOptions& options, CornerFit& fit);

}  // namespace srd::dsp
