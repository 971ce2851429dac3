// SPDX-License-Identifier: Apache-2.0
// What the light goes through: air, water, and flat floor plates of glass or acrylic on the pattern.
#pragma once

#include <array>
#include <cstddef>

namespace srd::dsp {

// A flat transparent plate that lies on the pattern (glass, acrylic).
template <class S>
struct Layer {
  S thickness = 0;  // mm
  S index = 1;
};

inline constexpr int kMaxLayers = 4;

// Refractive indices along the ray: air, water, then plates from the top down.
template <class S>
struct Media {
  S air = 1;
  S water = S(1.333);
  std::array<Layer<S>, kMaxLayers> layers{};
  int n_layers = 0;

  template <class T>
  [[nodiscard]] Media<T> cast() const {
    Media<T> out{static_cast<T>(air), static_cast<T>(water), {}, n_layers};
    for (std::size_t i = 0; i < kMaxLayers; ++i)
      out.layers[i] = {static_cast<T>(layers[i].thickness), static_cast<T>(layers[i].index)};
    return out;
  }

  // All plates together, mm.
  [[nodiscard]] S plates() const {
    S sum = 0;
    for (int i = 0; i < n_layers; ++i) sum += layers[static_cast<std::size_t>(i)].thickness;
    return sum;
  }
};

}  // namespace srd::dsp
