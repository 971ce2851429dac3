// SPDX-License-Identifier: Apache-2.0
// Fixed-point numbers with explicit conversions. Rounding (to nearest, halves away from zero) is part of the contract.
#pragma once

#include <compare>
#include <cstdint>
#include <type_traits>

namespace srd {

template <class Rep, int FractionBits>
class Fixed {
  static_assert(std::is_integral_v<Rep> && FractionBits >= 0 && FractionBits < static_cast<int>(8 * sizeof(Rep)));

 public:
  using rep = Rep;
  static constexpr int kFractionBits = FractionBits;
  static constexpr Rep kOne = static_cast<Rep>(Rep{1} << FractionBits);

  constexpr Fixed() = default;
  [[nodiscard]] static constexpr Fixed from_raw(Rep raw) {
    Fixed f;
    f.raw_ = raw;
    return f;
  }
  [[nodiscard]] static constexpr Fixed from_int(Rep whole) { return from_raw(static_cast<Rep>(whole * kOne)); }
  template <class Float>
  [[nodiscard]] static constexpr Fixed from_real(Float x) {
    const Float scaled = x * static_cast<Float>(kOne);
    return from_raw(static_cast<Rep>(scaled < Float(0) ? scaled - Float(0.5) : scaled + Float(0.5)));
  }
  [[nodiscard]] constexpr Rep raw() const { return raw_; }
  template <class Float>
  [[nodiscard]] constexpr Float to() const {
    return static_cast<Float>(raw_) / static_cast<Float>(kOne);
  }
  // Nearest whole number; halves go up.
  [[nodiscard]] constexpr Rep round() const { return static_cast<Rep>((raw_ + kOne / 2) >> FractionBits); }

  friend constexpr Fixed operator+(Fixed a, Fixed b) { return from_raw(static_cast<Rep>(a.raw_ + b.raw_)); }
  friend constexpr Fixed operator-(Fixed a, Fixed b) { return from_raw(static_cast<Rep>(a.raw_ - b.raw_)); }
  friend constexpr auto operator<=>(Fixed, Fixed) = default;

 private:
  Rep raw_ = 0;
};

// Image coordinates: 1/4096 px steps, +-524288 px. Quantisation adds 1/4096/sqrt(12) = 7e-5 px rms.
using Pixel = Fixed<std::int32_t, 12>;

}  // namespace srd
