// SPDX-License-Identifier: Apache-2.0
// Residual of one corner on the bottom plane in whole numbers: ray (4), surface (5), its crossing (6), refraction (7),
// bottom point (8), disparity (9). Shows that the arithmetic of a board without floating point fits 32-bit storage and
// 64-bit products; within 1e-4 mm of the double residual.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "dsp/core/fixed.hpp"
#include "dsp/core/integer_math.hpp"
#include "dsp/estimate/fixed_point/fixed_trig.hpp"
#include "dsp/optics/media.hpp"
#include "dsp/optics/surface_model.hpp"
#include "dsp/optics/view.hpp"

namespace srd::dsp {

// Stored in 32 bits. The ranges below are kept by the quantisers; outside, they refuse.
using FixedLength = Fixed<std::int32_t, 18>;  // mm, 4e-6 steps
using FixedUnit = Fixed<std::int32_t, 30>;    // parts of unit vectors, |x| < 2
using FixedRatio = Fixed<std::int32_t, 28>;   // refractive indices, undistorted pixels, |x| < 8

inline constexpr int kFixedLengthBits = 12;    // |c|, |c - F|, |b - F| < 2^12 mm = 4.1 m an axis; |F| half of that
inline constexpr int kFixedLevelBits = 2;      // d_z < -1/4: the way down the ray is at most four times the height
inline constexpr int kFixedHeightBits = 10;    // sum of |a_j| < 2^10 mm
inline constexpr int kFixedBendBits = 12;      // sum of |a_j| times its harmonic < 2^12 mm
inline constexpr int kFixedLineBits = 2;       // |X - X0| < 4 Lx over the pattern, for the linear modes
inline constexpr int kFixedWaveBits = -3;      // pi/Lx < 1/8 per mm: Lx > 25.2 mm
inline constexpr int kFixedWaveFraction = 34;  // of pi/Lx

// The way down the ray times a part of a unit vector, and likewise before it is divided by one.
static_assert(kFixedLengthBits + kFixedLevelBits + FixedLength::kFractionBits + FixedUnit::kFractionBits <= 62);
// Phases: X - X0, the sum of three lengths, brought to Q49 before it is divided by the wave's length.
static_assert(kFixedLengthBits + 1 + FixedLength::kFractionBits + 31 <= 62);
// Heights: sum of a_j phi_j with |phi| < 2^kFixedLineBits.
static_assert(kFixedHeightBits + FixedLength::kFractionBits + kFixedLineBits + FixedUnit::kFractionBits <= 62);
// Slopes: sum of a_j m sin cos in mm; brought back to a length, times pi/Lx.
static_assert(kFixedBendBits + FixedLength::kFractionBits + FixedUnit::kFractionBits <= 62);
static_assert(kFixedBendBits + FixedLength::kFractionBits + kFixedWaveBits + kFixedWaveFraction <= 62);
// Squares of unit vectors, at most 4 in all; squares of indices, at most 16.
static_assert(2 + 2 * FixedUnit::kFractionBits <= 63 && 4 + 2 * FixedRatio::kFractionBits <= 63);

struct FixedView {
  std::array<std::array<FixedUnit, 3>, 3> rotation{};  // R
  std::array<FixedLength, 3> centre{};                 // c
};

struct FixedSurface {
  ModeList modes;
  std::array<FixedLength, kMaxModes> coefficients{};
  FixedLength lx, ly, x0, y0;
};

struct FixedMedia {
  FixedUnit air_per_water;  // r
  FixedRatio water;
  std::array<FixedLength, kMaxLayers> thickness{};
  std::array<FixedRatio, kMaxLayers> index{};
  int n_layers = 0;
};

using FixedPoint = std::array<FixedLength, 3>;

// Nothing for numbers outside the ranges above.
[[nodiscard]] std::optional<FixedView> quantise(const View<double>& view);
[[nodiscard]] std::optional<FixedSurface> quantise(const SurfaceModel<double>& model, const Coefficients<double>& a);
[[nodiscard]] std::optional<FixedMedia> quantise(const Media<double>& media);  // air 1, or less than water
[[nodiscard]] std::optional<FixedPoint> quantise(const Vec3<double>& point);
[[nodiscard]] std::optional<std::array<FixedRatio, 2>> quantise(const Vec2<double>& normalised);

// I: the 64-bit arithmetic; a test puts in one that notices overflow.
template <class I>
class FixedResidual {
 public:
  FixedResidual(const FixedView& view, const FixedSurface& surface, const FixedMedia& media)
      : view_(view), surface_(surface), media_(media) {}

  // e = b - F, mm. False: no view of the surface from above (6), total reflection, water under the plates, the crossing
  // is not found, or a distance is beyond its range.
  [[nodiscard]] bool evaluate(const FixedPoint& point, const std::array<FixedRatio, 2>& normalised,
                              std::array<FixedLength, 2>& e) const {
    std::array<I, 3> d;
    ray(normalised, d);
    if (!(d[2] < I(-(kUnitOne >> kFixedLevelBits)))) return false;
    // Everything from F on, so that no digits go to the camera's distance.
    std::array<I, 3> from_point;
    for (std::size_t i = 0; i < 3; ++i) from_point[i] = raw(view_.centre[i]) - raw(point[i]);
    for (const I& x : from_point)
      if (!in_range(x)) return false;
    const I dry_distance = -quotient(from_point[2], d[2]);
    std::array<I, 2> dry;
    for (std::size_t i = 0; i < 2; ++i) {
      dry[i] = from_point[i] + product(dry_distance, d[i]);
      if (!in_range(dry[i])) return false;
    }

    Sample at;
    std::array<I, 2> foot = dry;
    sample(raw(point[0]) + foot[0], raw(point[1]) + foot[1], at);
    I along = quotient(at.z - raw(point[2]), d[2]);
    for (int iteration = 0;; ++iteration) {
      for (std::size_t i = 0; i < 2; ++i) {
        foot[i] = dry[i] + product(along, d[i]);
        if (!in_range(foot[i])) return false;
      }
      sample(raw(point[0]) + foot[0], raw(point[1]) + foot[1], at);
      const I h = d[2] - ((at.zx * d[0] + at.zy * d[1]) >> kUnit);
      if (!(h < I(-kUnitOne / 16))) return false;
      const I step = -quotient(product(along, d[2]) - (at.z - raw(point[2])), h);  // (6)
      along = along + step;
      if (I(-kLastStep) < step && step < I(kLastStep)) break;
      if (iteration == kMaxIterations) return false;
    }
    return refract(d, at, product(along, d[2]), foot, e);
  }

 private:
  static constexpr int kUnit = FixedUnit::kFractionBits, kRatio = FixedRatio::kFractionBits;
  static constexpr std::int64_t kUnitOne = std::int64_t{1} << kUnit;
  static constexpr int kMaxIterations = 20;
  // 6e-5 mm: a unit of rounding in the heights is up to 16 along a level ray; the next step would be nothing but that.
  static constexpr int kLastStep = 16;

  struct Sample {
    I z = I(0), zx = I(0), zy = I(0);  // length; slopes as FixedUnit
  };
  // Harmonics and the straight line along one axis.
  struct Factors {
    std::array<I, kMaxHarmonic + 1> cosine, sine;
    I line = I(0), per_length = I(0);  // X/Lx; 1 mm/Lx, both as FixedUnit
    I wave = I(0);                     // pi/Lx, 1/mm
  };

  template <class Rep, int Bits>
  [[nodiscard]] static I raw(Fixed<Rep, Bits> x) {
    return I(static_cast<std::int64_t>(x.raw()));
  }
  [[nodiscard]] static bool in_range(I length) {
    const I most = I(std::int64_t{1} << (kFixedLengthBits + FixedLength::kFractionBits));
    return I(0) - most < length && length < most;
  }
  [[nodiscard]] static I product(I length, I unit) { return (length * unit + I(kUnitOne / 2)) >> kUnit; }
  // As a length where a is one, over a part of a unit vector.
  [[nodiscard]] static I quotient(I a, I unit) { return (a * I(kUnitOne)) / unit; }
  [[nodiscard]] static I root(I square) {
    return I(static_cast<std::int64_t>(isqrt(static_cast<std::uint64_t>(static_cast<std::int64_t>(square)))));
  }

  // (4): |R'(x, y, 1)|^2 = 1 + x^2 + y^2 < 4, |x|, |y| < 1.2.
  void ray(const std::array<FixedRatio, 2>& normalised, std::array<I, 3>& d) const {
    const std::array<I, 3> seen{raw(normalised[0]), raw(normalised[1]), I(std::int64_t{1} << kRatio)};
    I square = I(0);
    for (std::size_t i = 0; i < 3; ++i) {
      I sum = I(0);
      for (std::size_t k = 0; k < 3; ++k) sum = sum + raw(view_.rotation[k][i]) * seen[k];
      d[i] = sum >> kRatio;
      square = square + d[i] * d[i];
    }
    const I length = root(square);
    for (I& x : d) x = quotient(x, length);
  }

  void factors(I distance, FixedLength length, int highest, Factors& out) const {
    const I full = raw(length);
    out.line = quotient(distance, full);
    out.per_length = quotient(I(FixedLength::kOne), full);
    constexpr auto kPi = static_cast<std::int64_t>(3.14159265358979323846 * static_cast<double>(std::int64_t{1} << 30) + 0.5);
    // pi (Q30) / Lx (Q18), brought to kFixedWaveFraction bits.
    out.wave = (I(kPi) * I(std::int64_t{1} << (kFixedWaveFraction - 30 + FixedLength::kFractionBits))) / full;
    // Half of X/Lx is the turn, modulo 1.
    const I turn = (distance * I(std::int64_t{1} << 31)) / full;
    const SineCosine first = sin_cos_of_turn(static_cast<std::uint32_t>(static_cast<std::int64_t>(turn)));
    out.cosine[0] = I(kUnitOne);
    out.sine[0] = I(0);
    for (std::size_t m = 1; m <= static_cast<std::size_t>(highest); ++m) {
      const I c = out.cosine[m - 1], s = out.sine[m - 1];
      out.cosine[m] = (c * I(first.cosine) - s * I(first.sine)) >> kUnit;
      out.sine[m] = (s * I(first.cosine) + c * I(first.sine)) >> kUnit;
    }
  }

  // (5) at X, Y.
  void sample(I x, I y, Sample& out) const {
    Factors fx, fy;
    factors(x - raw(surface_.x0), surface_.lx, surface_.modes.highest_x(), fx);
    factors(y - raw(surface_.y0), surface_.ly, surface_.modes.highest_y(), fy);
    I z = I(0), by_phase_x = I(0), by_phase_y = I(0);
    out.zx = out.zy = I(0);
    for (int j = 0; j < surface_.modes.size(); ++j) {
      const Mode& mode = surface_.modes[j];
      const I a = raw(surface_.coefficients[static_cast<std::size_t>(j)]);
      switch (mode.kind) {
        case Mode::Kind::kSlopeX:
          z = z + a * fx.line;
          out.zx = out.zx + ((a * fx.per_length) >> FixedLength::kFractionBits);
          break;
        case Mode::Kind::kSlopeY:
          z = z + a * fy.line;
          out.zy = out.zy + ((a * fy.per_length) >> FixedLength::kFractionBits);
          break;
        case Mode::Kind::kCosine:
          const I cx = fx.cosine[mode.m], cy = fy.cosine[mode.n];
          z = z + a * ((cx * cy) >> kUnit);
          by_phase_x = by_phase_x - a * I(mode.m) * ((fx.sine[mode.m] * cy) >> kUnit);
          by_phase_y = by_phase_y - a * I(mode.n) * ((cx * fy.sine[mode.n]) >> kUnit);
          break;
      }
    }
    out.z = z >> kUnit;
    // Length times 1/mm: Q18 + Q34 down to Q30.
    constexpr int kDown = FixedLength::kFractionBits + kFixedWaveFraction - kUnit;
    out.zx = out.zx + (((by_phase_x >> kUnit) * fx.wave) >> kDown);
    out.zy = out.zy + (((by_phase_y >> kUnit) * fy.wave) >> kDown);
  }

  // (7), (8), (9), with the plates.
  [[nodiscard]] bool refract(const std::array<I, 3>& d, const Sample& at, I height, const std::array<I, 2>& foot,
                             std::array<FixedLength, 2>& e) const {
    const I m = root(I(kUnitOne) * I(kUnitOne) + at.zx * at.zx + at.zy * at.zy);
    const std::array<I, 3> n{-quotient(at.zx, m), -quotient(at.zy, m), quotient(I(kUnitOne), m)};
    const I r = raw(media_.air_per_water);
    const I ci = -((d[0] * n[0] + d[1] * n[1] + d[2] * n[2]) >> kUnit);
    const I sine2 = I(kUnitOne) - ((ci * ci) >> kUnit);
    const I root2 = I(kUnitOne) - ((((r * r) >> kUnit) * sine2) >> kUnit);
    if (!(I(0) < ci) || !(I(0) < root2)) return false;
    const I k = ((r * ci) >> kUnit) - root(root2 * I(kUnitOne));
    std::array<I, 3> v;
    for (std::size_t i = 0; i < 3; ++i) v[i] = (r * d[i] + k * n[i]) >> kUnit;
    if (!(v[2] < I(-kUnitOne / 8))) return false;
    I depth = height;
    for (int i = 0; i < media_.n_layers; ++i) depth = depth - raw(media_.thickness[static_cast<std::size_t>(i)]);
    if (depth < I(0)) return false;
    std::array<I, 2> level;  // horizontal part of index times direction, as FixedRatio
    I level2 = I(0);
    for (std::size_t i = 0; i < 2; ++i) {
      level[i] = (raw(media_.water) * v[i]) >> kUnit;
      level2 = level2 + level[i] * level[i];
    }
    std::array<I, 2> sum;
    for (std::size_t i = 0; i < 2; ++i) sum[i] = foot[i] - product(depth, quotient(v[i], v[2]));
    for (int layer = 0; layer < media_.n_layers; ++layer) {
      const I index = raw(media_.index[static_cast<std::size_t>(layer)]);
      const I c2 = index * index - level2;
      if (!(I(0) < c2)) return false;
      const I c = root(c2);
      for (std::size_t i = 0; i < 2; ++i)
        sum[i] = sum[i] + (raw(media_.thickness[static_cast<std::size_t>(layer)]) * level[i]) / c;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const auto wide = static_cast<std::int64_t>(sum[i]);
      const auto narrow = static_cast<std::int32_t>(wide);
      if (narrow != wide) return false;
      e[i] = FixedLength::from_raw(narrow);
    }
    return true;
  }

  const FixedView& view_;
  const FixedSurface& surface_;
  const FixedMedia& media_;
};

}  // namespace srd::dsp
