// SPDX-License-Identifier: Apache-2.0
#include "dsp/frontend/faint_corner.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace srd::dsp {

namespace {

constexpr int kHalf = 3;                              // samples to either side of the middle
constexpr int kSide = 2 * kHalf + 1;                  // of a row of samples
constexpr float kSpacing = 0.5f / kHalf;              // steps: the outermost samples lie in the middles of the four squares
constexpr int kTries = 5;                             // moves to where the surface through the samples is level
constexpr float kFurthest = 0.40f, kSettled = 0.02f;  // steps
constexpr float kLeastContrast = 4;                   // grey levels
constexpr float kOfUsual = 0.1f;
constexpr float kAlike = 0.55f;  // of the samples' variance, what a corner's pattern explains; an edge's is 0, a bar's less

using Samples = std::array<float, kSide * kSide>;

// The image at the lattice's places round (row, column), from the map's, by bilinear interpolation. False: outside.
bool take_samples(const GrayView& image, const CornerLattice::LocalMap& map, float row, float column, Samples& samples) {
  for (int i = 0; i < kSide; ++i)
    for (int k = 0; k < kSide; ++k) {
      const float r = row + kSpacing * static_cast<float>(i - kHalf), c = column + kSpacing * static_cast<float>(k - kHalf);
      const float u = map.u + r * map.row_u + c * map.column_u, v = map.v + r * map.row_v + c * map.column_v;
      if (!(u >= 0 && v >= 0 && u < static_cast<float>(image.width - 1) && v < static_cast<float>(image.height - 1)))
        return false;
      const int cu = static_cast<int>(u), cv = static_cast<int>(v);
      const float fu = u - static_cast<float>(cu), fv = v - static_cast<float>(cv);
      const std::uint8_t *above = image.row(cv) + cu, *below = image.row(cv + 1) + cu;
      const float top = static_cast<float>(above[0]) * (1 - fu) + static_cast<float>(above[1]) * fu;
      const float bottom = static_cast<float>(below[0]) * (1 - fu) + static_cast<float>(below[1]) * fu;
      samples[static_cast<std::size_t>(i * kSide + k)] = top * (1 - fv) + bottom * fv;
    }
  return true;
}

// Least squares of a + b r + d c + e r c + f r^2 + g c^2 on the samples, r and c in their spacings from the middle. All but
// the constant and the squares are orthogonal; the constant is not needed.
struct Paraboloid {
  float row = 0, column = 0, cross = 0, row_row = 0, column_column = 0;
  explicit Paraboloid(const Samples& samples) {
    float sum = 0, rr = 0, cc = 0;
    for (int i = -kHalf; i <= kHalf; ++i)
      for (int k = -kHalf; k <= kHalf; ++k) {
        const float s = samples[static_cast<std::size_t>((i + kHalf) * kSide + k + kHalf)];
        const float r = static_cast<float>(i), c = static_cast<float>(k);
        sum += s;
        row += s * r;
        column += s * c;
        cross += s * r * c;
        rr += s * r * r;
        cc += s * c * c;
      }
    // Over -3 .. 3: the mean of r^2 is 4, of r^4 28.
    constexpr float kMean2 = 4, kMean4 = 28, kAll = kSide * kSide;
    static_assert(kHalf == 3);
    row /= kAll * kMean2;
    column /= kAll * kMean2;
    cross /= kAll * kMean2 * kMean2;
    row_row = (rr - kMean2 * sum) / (kAll * (kMean4 - kMean2 * kMean2));
    column_column = (cc - kMean2 * sum) / (kAll * (kMean4 - kMean2 * kMean2));
  }
};

// What the samples share with a blurred corner's sin(pi r) sin(pi c).
struct Likeness {
  float amplitude = 0;  // grey levels, of the pattern
  float share = 0;      // of the samples' variance
};

Likeness likeness_of(const Samples& samples) {
  // sin(pi r) at the samples' places, and its square's sum over a row: 7/2 - cos terms = 4.
  constexpr std::array<float, kSide> kSine{-1, -0.8660254f, -0.5f, 0, 0.5f, 0.8660254f, 1};
  constexpr float kSquares = 4;
  float sum = 0, squares = 0, product = 0;
  for (std::size_t i = 0; i < kSide; ++i)
    for (std::size_t k = 0; k < kSide; ++k) {
      const float s = samples[i * kSide + k];
      sum += s;
      squares += s * s;
      product += s * kSine[i] * kSine[k];
    }
  const float variance = squares - sum * sum / (kSide * kSide);
  if (!(variance > 0)) return {};
  return {product / (kSquares * kSquares), product * product / (kSquares * kSquares * variance)};
}

// The corners of the samples are the squares' middles: the darker bright one against the brighter dark one, grey levels.
float alternation(const Samples& samples, float sign) {
  const auto middle = [&](int row, int column) {
    float sum = 0;
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 2; ++k)
        sum += samples[static_cast<std::size_t>((row > 0 ? kSide - 1 - i : i) * kSide + (column > 0 ? kSide - 1 - k : k))];
    return 0.25f * sign * sum;
  };
  return std::min(middle(1, 1), middle(-1, -1)) - std::max(middle(1, -1), middle(-1, 1));
}

}  // namespace

bool find_faint_corner(const GrayView& image, const CornerLattice::LocalMap& map, bool bright, float usual_contrast,
                       FaintCorner& corner) {
  const float sign = bright ? 1.0f : -1.0f;
  float row = 0, column = 0;
  Samples samples{};
  bool settled = false;
  for (int k = 0; k < kTries && !settled; ++k) {
    if (!take_samples(image, map, row, column, samples)) return false;
    const Paraboloid p(samples);
    // Level ground of a saddle: b + e c + 2 f r = 0, d + e r + 2 g c = 0.
    const float det = p.cross * p.cross - 4 * p.row_row * p.column_column;
    if (!(sign * p.cross > 0 && det > 0.25f * p.cross * p.cross)) return false;
    const float r = (2 * p.column_column * p.row - p.cross * p.column) / det;
    const float c = (2 * p.row_row * p.column - p.cross * p.row) / det;
    const float length = std::hypot(r, c), most = kHalf / 2.0f, shorten = length > most ? most / length : 1.0f;
    row += kSpacing * shorten * r;
    column += kSpacing * shorten * c;
    if (!(std::hypot(row, column) <= kFurthest)) return false;
    settled = kSpacing * length <= kSettled;
  }
  if (!take_samples(image, map, row, column, samples)) return false;
  const Likeness like = likeness_of(samples);
  const float least = std::max(kLeastContrast, kOfUsual * usual_contrast);
  if (2 * sign * like.amplitude < least || like.share < kAlike) return false;
  if (alternation(samples, sign) < 0.25f * least) return false;
  corner.likeness = like.share;
  corner.u = map.u + row * map.row_u + column * map.column_u;
  corner.v = map.v + row * map.row_v + column * map.column_v;
  corner.contrast = 2 * sign * like.amplitude;
  return true;
}

}  // namespace srd::dsp
