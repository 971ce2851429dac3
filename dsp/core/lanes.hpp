// SPDX-License-Identifier: Apache-2.0
// Several numbers that go through the same arithmetic at once, in one 128-bit register: 4 float or 2 double. Stands in
// for a scalar in templates. A comparison is true when it holds in every lane: write conditions as what must hold.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

namespace srd::dsp {

template <class S>
class Lanes {
 public:
  using Vector [[gnu::vector_size(16)]] = S;
  static constexpr int kSize = 16 / static_cast<int>(sizeof(S));

  Lanes() = default;
  // The same number in every lane.
  template <class Number, class = std::enable_if_t<std::is_arithmetic_v<Number>>>
  [[gnu::always_inline]] Lanes(Number x) : v_(Vector{} + static_cast<S>(x)) {}  // NOLINT: meant to convert

  [[nodiscard]] S operator[](int lane) const { return v_[lane]; }
  void set(int lane, S x) { v_[lane] = x; }
  // Over all lanes, in double.
  [[nodiscard]] double sum() const {
    double out = 0;
    for (int i = 0; i < kSize; ++i) out += static_cast<double>(v_[i]);
    return out;
  }

  [[gnu::always_inline]] friend Lanes operator+(Lanes a, Lanes b) { return Lanes(a.v_ + b.v_, 0); }
  [[gnu::always_inline]] friend Lanes operator-(Lanes a, Lanes b) { return Lanes(a.v_ - b.v_, 0); }
  [[gnu::always_inline]] friend Lanes operator*(Lanes a, Lanes b) { return Lanes(a.v_ * b.v_, 0); }
  [[gnu::always_inline]] friend Lanes operator/(Lanes a, Lanes b) { return Lanes(a.v_ / b.v_, 0); }
  [[gnu::always_inline]] friend Lanes operator-(Lanes a) { return Lanes(-a.v_, 0); }
  [[gnu::always_inline]] Lanes& operator+=(Lanes b) {
    v_ += b.v_;
    return *this;
  }
  [[gnu::always_inline]] Lanes& operator-=(Lanes b) {
    v_ -= b.v_;
    return *this;
  }
  [[gnu::always_inline]] Lanes& operator*=(Lanes b) {
    v_ *= b.v_;
    return *this;
  }
  [[gnu::always_inline]] Lanes& operator/=(Lanes b) {
    v_ /= b.v_;
    return *this;
  }

  [[gnu::always_inline]] friend bool operator<(Lanes a, Lanes b) { return all(a.v_ < b.v_); }
  [[gnu::always_inline]] friend bool operator<=(Lanes a, Lanes b) { return all(a.v_ <= b.v_); }
  [[gnu::always_inline]] friend bool operator>(Lanes a, Lanes b) { return all(a.v_ > b.v_); }
  [[gnu::always_inline]] friend bool operator>=(Lanes a, Lanes b) { return all(a.v_ >= b.v_); }
  [[gnu::always_inline]] friend bool operator==(Lanes a, Lanes b) { return all(a.v_ == b.v_); }
  [[gnu::always_inline]] friend bool operator!=(Lanes a, Lanes b) { return !(a == b); }

  [[gnu::always_inline]] friend Lanes sqrt(Lanes a) {
    for (int i = 0; i < kSize; ++i) a.v_[i] = std::sqrt(a.v_[i]);
    return a;
  }
  // Float: Cephes' polynomials on an eighth of a turn, both from one reduction; within 1.2e-7 for |a| < 1000, and equal
  // bit for bit on every machine.
  [[gnu::always_inline]] friend void sin_cos(Lanes a, Lanes& sine, Lanes& cosine) {
    if constexpr (sizeof(S) == sizeof(float)) {
      using Ints [[gnu::vector_size(16)]] = int;
      // Adding 1.5 2^23 leaves the nearest whole number of quarter turns in the lowest bits.
      const Vector shifted = a.v_ * S(2 / M_PI) + S(12582912);
      const Ints quarter = (Ints)shifted;
      const Vector turns = shifted - S(12582912);
      // pi/2 in three parts, so that the products are exact.
      const Vector x = a.v_ - turns * S(1.5703125) - turns * S(4.837512969970703125e-4) - turns * S(7.54978995489188216e-8);
      const Vector x2 = x * x;
      const Vector s = ((S(-1.9515295891e-4) * x2 + S(8.3321608736e-3)) * x2 - S(1.6666654611e-1)) * x2 * x + x;
      const Vector c = ((S(2.443315711809948e-5) * x2 - S(1.388731625493765e-3)) * x2 + S(4.166664568298827e-2)) * x2 * x2 -
                       S(0.5) * x2 + S(1);
      const Ints odd = (quarter & 1) != 0;
      const Ints s_bits = (Ints)s, c_bits = (Ints)c;
      sine.v_ = (Vector)(((odd & c_bits) | (~odd & s_bits)) ^ ((quarter & 2) << 30));
      cosine.v_ = (Vector)(((odd & s_bits) | (~odd & c_bits)) ^ (((quarter + 1) & 2) << 30));
    } else {
      for (int i = 0; i < kSize; ++i) {
        sine.v_[i] = std::sin(a.v_[i]);
        cosine.v_[i] = std::cos(a.v_[i]);
      }
    }
  }
  [[gnu::always_inline]] friend Lanes abs(Lanes a) { return Lanes(a.v_ < 0 ? -a.v_ : a.v_, 0); }
  [[gnu::always_inline]] friend Lanes copysign(Lanes size, Lanes sign) {
    const Lanes positive = abs(size);
    return Lanes(sign.v_ < 0 ? -positive.v_ : positive.v_, 0);
  }
  // No lane is a NaN or infinite.
  [[gnu::always_inline]] friend bool isfinite(Lanes a) { return all(a.v_ - a.v_ == 0); }

 private:
  [[gnu::always_inline]] Lanes(Vector v, int) : v_(v) {}
  template <class Mask>
  [[gnu::always_inline]] static bool all(Mask mask) {
    using Halves [[gnu::vector_size(16)]] = long long;
    const Halves halves = (Halves)mask;
    return (halves[0] & halves[1]) == -1;
  }

  Vector v_;
};

template <class S, class = std::enable_if_t<std::is_floating_point_v<S>>>
void sin_cos(S a, S& sine, S& cosine) {
  sine = std::sin(a);
  cosine = std::cos(a);
}

// The same numbers in double: two registers for float, one for double.
[[gnu::always_inline]] inline void widen(Lanes<float> a, Lanes<double>* out) {
  Lanes<double> low(0.0), high(0.0);  // GCC for arm64 takes filling lane by lane for a read of what was there
  for (int i = 0; i < 2; ++i) {
    low.set(i, static_cast<double>(a[i]));
    high.set(i, static_cast<double>(a[2 + i]));
  }
  out[0] = low;
  out[1] = high;
}
[[gnu::always_inline]] inline void widen(Lanes<double> a, Lanes<double>* out) { *out = a; }

// The number type of one lane.
template <class T>
struct LaneOf {
  using Type = T;
};
template <class S>
struct LaneOf<Lanes<S>> {
  using Type = S;
};

}  // namespace srd::dsp

namespace Eigen {
template <class S>
struct NumTraits<srd::dsp::Lanes<S>> : GenericNumTraits<srd::dsp::Lanes<S>> {
  using Real = srd::dsp::Lanes<S>;
  using NonInteger = Real;
  using Nested = Real;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 0, ReadCost = 1, AddCost = 1, MulCost = 1 };
};
}  // namespace Eigen
