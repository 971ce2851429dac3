// SPDX-License-Identifier: Apache-2.0
// The water surface as a short sum of modes, with its slopes and curvatures. Optics (5).
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "dsp/core/lanes.hpp"
#include "dsp/core/linear_algebra.hpp"
#include "dsp/core/result.hpp"

namespace srd::dsp {

inline constexpr int kMaxModes = 24;
// Of one fit: the modes and the index of water; rounded up so that arrays of them stay aligned.
inline constexpr int kMaxParameters = 28;
inline constexpr int kMaxHarmonic = 9;  // one digit, so that names stay unambiguous

// A_mn: cos(m pi X/Lx) cos(n pi Y/Ly); B: X/Lx; C: Y/Ly.
struct Mode {
  enum class Kind : std::uint8_t { kCosine, kSlopeX, kSlopeY };
  Kind kind = Kind::kCosine;
  std::uint8_t m = 0, n = 0;
  friend constexpr bool operator==(const Mode&, const Mode&) = default;
  // "A00", "B", "C", "A21"; always NUL-terminated.
  [[nodiscard]] std::array<char, 4> name() const;
  [[nodiscard]] static std::optional<Mode> parse(std::string_view name);
};

// Up to 24 different modes, in the order of their coefficients.
class ModeList {
 public:
  ModeList() = default;
  // The published prefixes: 1, 3, 5, 8 or 12 parameters; kInvalidArgument otherwise.
  [[nodiscard]] static Result<ModeList> standard(int parameters);
  // kInvalidArgument for none, a repeated mode or a harmonic above 9; kTooSmall above 24.
  [[nodiscard]] static Result<ModeList> make(std::span<const Mode> modes);

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] const Mode& operator[](int i) const { return modes_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Mode* begin() const { return modes_.data(); }
  [[nodiscard]] const Mode* end() const { return modes_.data() + size_; }
  [[nodiscard]] int index_of(Mode mode) const;  // -1 when absent
  // The highest harmonic across X and Y.
  [[nodiscard]] int highest_x() const { return highest_x_; }
  [[nodiscard]] int highest_y() const { return highest_y_; }
  friend bool operator==(const ModeList& a, const ModeList& b) {
    if (a.size_ != b.size_) return false;
    for (int i = 0; i < a.size_; ++i)
      if (!(a[i] == b[i])) return false;
    return true;
  }

 private:
  std::array<Mode, kMaxModes> modes_{};
  int size_ = 0;
  int highest_x_ = 0, highest_y_ = 0;
};

// Coefficients of a surface, mm, in the order of its mode list, or all parameters of a fit. Fixed capacity: no heap.
template <class S>
using Coefficients = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;

// Height (mm), slopes and curvatures (1/mm) of a surface at one (X, Y).
template <class S>
struct SurfaceSample {
  S z = 0, zx = 0, zy = 0, zxx = 0, zxy = 0, zyy = 0;
};

// phi_j, d phi_j/dX, d phi_j/dY at one (X, Y).
template <class S>
struct Basis {
  Coefficients<S> value, dx, dy;
};

template <class S>
struct SurfaceModel {
  ModeList modes;
  S lx = 1, ly = 1;  // length scales, mm
  S x0 = 0, y0 = 0;  // origin, mm

  template <class T>
  [[nodiscard]] SurfaceModel<T> cast() const {
    return {modes, static_cast<T>(lx), static_cast<T>(ly), static_cast<T>(x0), static_cast<T>(y0)};
  }

  [[nodiscard]] SurfaceSample<S> sample(const Coefficients<S>& a, S x, S y) const { return evaluate(&a, x, y, nullptr); }
  [[nodiscard]] S height(const Coefficients<S>& a, S x, S y) const { return sample(a, x, y).z; }
  void basis(S x, S y, Basis<S>& out) const { (void)evaluate(nullptr, x, y, &out); }

  // Both at once: the sample of a and the basis.
  SurfaceSample<S> evaluate(const Coefficients<S>* a, S x, S y, Basis<S>* out) const;

 private:
  struct Factor {
    S value, slope, curvature;
  };
  static constexpr std::size_t kLine = kMaxHarmonic + 1;
  using Factors = std::array<Factor, kLine + 1>;

  // cos of 0, 1, .. highest times wave_number distance and its derivatives, by the addition theorem.
  static void fill(S wave_number, S distance, int highest, Factors& factors);
};

template <class S>
SurfaceSample<S> SurfaceModel<S>::evaluate(const Coefficients<S>* a, S x, S y, Basis<S>* out) const {
  // Every mode is a product f(X) g(Y): harmonics 0 to 9 and, last, the straight line.
  Factors fx, fy;
  fill(S(M_PI) / lx, x - x0, modes.highest_x(), fx);
  fill(S(M_PI) / ly, y - y0, modes.highest_y(), fy);
  fx[kLine] = {(x - x0) / lx, 1 / lx, 0};
  fy[kLine] = {(y - y0) / ly, 1 / ly, 0};
  SurfaceSample<S> sum;
  const int n_modes = modes.size();
  if (out != nullptr) {
    out->value.resize(n_modes);
    out->dx.resize(n_modes);
    out->dy.resize(n_modes);
  }
  for (int j = 0; j < n_modes; ++j) {
    const Mode& mode = modes[j];
    const Factor& f = fx[mode.kind == Mode::Kind::kSlopeX ? kLine : mode.m];
    const Factor& g = fy[mode.kind == Mode::Kind::kSlopeY ? kLine : mode.n];
    const S v = f.value * g.value, vx = f.slope * g.value, vy = f.value * g.slope;
    if (a != nullptr) {
      const S aj = (*a)[j];
      sum.z += aj * v;
      sum.zx += aj * vx;
      sum.zy += aj * vy;
      sum.zxx += aj * (f.curvature * g.value);
      sum.zxy += aj * (f.slope * g.slope);
      sum.zyy += aj * (f.value * g.curvature);
    }
    if (out != nullptr) {
      out->value[j] = v;
      out->dx[j] = vx;
      out->dy[j] = vy;
    }
  }
  return sum;
}

template <class S>
void SurfaceModel<S>::fill(S wave_number, S distance, int highest, Factors& factors) {
  factors[0] = {1, 0, 0};
  if (highest == 0) return;
  S c1, s1;
  sin_cos(wave_number * distance, s1, c1);
  S c = 1, s = 0;
  for (int i = 1; i <= highest; ++i) {
    const S next = c * c1 - s * s1;
    s = s * c1 + c * s1;
    c = next;
    const S w = wave_number * static_cast<S>(i);
    factors[static_cast<std::size_t>(i)] = {c, -w * s, -w * w * c};
  }
}

extern template struct SurfaceModel<float>;
extern template struct SurfaceModel<double>;

}  // namespace srd::dsp
