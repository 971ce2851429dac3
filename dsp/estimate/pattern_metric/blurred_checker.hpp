// SPDX-License-Identifier: Apache-2.0
// Brightness of an endless checkerboard seen through a Gaussian blur, with its derivatives. Optics (12b).
#pragma once

#include <array>
#include <cmath>

namespace srd::dsp {

// The blurred square wave W: +1 between 0 and 1, -1 between 1 and 2, and so on. d[k] = sigma^k times its k-th derivative.
struct BlurredWave {
  static constexpr int kDerivatives = 5;
  std::array<double, kDerivatives + 1> d{};
};

// x: squares; per_sigma: 1/sigma, 1/squares, at least kMinPerSigma: three edges then stand for all. Exact to 1e-6.
inline constexpr double kMinPerSigma = 3.5;
inline constexpr double kFarFromEdge = 5.5;  // sigmas; beyond, 4e-8 is left

[[nodiscard]] inline BlurredWave blurred_wave(double x, double per_sigma) {
  BlurredWave out;
  const double n = std::floor(x + 0.5);
  const double nearest = std::fmod(n, 2.0) == 0 ? 1 : -1;
  const double z = (x - n) * per_sigma;
  const auto add = [&out](double at, double sign) {
    if (std::abs(at) > kFarFromEdge) {
      out.d[0] += at > 0 ? sign : -sign;
      return;
    }
    // Derivatives of erf(z / sqrt 2): Hermite polynomials times the normal density.
    const double z2 = at * at;
    const double density = sign * std::sqrt(2 / M_PI) * std::exp(-0.5 * z2);
    out.d[0] += sign * std::erf(at * M_SQRT1_2);
    out.d[1] += density;
    out.d[2] -= density * at;
    out.d[3] += density * (z2 - 1);
    out.d[4] -= density * at * (z2 - 3);
    out.d[5] += density * (z2 * z2 - 6 * z2 + 3);
  };
  add(z, nearest);
  add(z - per_sigma, -nearest);
  add(z + per_sigma, -nearest);
  return out;
}

// How the blur of one pixel lies on the pattern, for a blur of 1 px: inverse deviations (1/squares) and correlation.
struct BlurFootprint {
  double per_sigma_x = 1, per_sigma_y = 1, correlation = 0;
};

// -1 dark .. +1 bright, and its derivatives.
struct CheckerSample {
  double shape = 0;
  double by_x = 0, by_y = 0;  // 1/squares
  double by_blur = 0;         // 1/px
  bool flat = false;          // no edge within reach: all derivatives are 0
};

// x, y: squares from a corner whose square towards +x, +y is dark. blur_px: sigma, > 0.
// Mean of W(X) W(Y) over a bivariate normal: Mehler's series in the correlation, cut after its third power; the fourth
// is below 0.002 for |correlation| <= 0.4.
[[nodiscard]] inline CheckerSample blurred_checker(double x, double y, const BlurFootprint& foot, double blur_px) {
  const double per_x = foot.per_sigma_x / blur_px, per_y = foot.per_sigma_y / blur_px;
  CheckerSample out;
  const BlurredWave wx = blurred_wave(x, per_x), wy = blurred_wave(y, per_y);
  if (wx.d[1] == 0 && wy.d[1] == 0) {
    out.shape = -wx.d[0] * wy.d[0];
    out.flat = true;
    return out;
  }
  double factor = -1;  // rho^k / k!, and the dark square's sign
  for (std::size_t k = 0; k <= 3; ++k) {
    const double power = static_cast<double>(k);
    out.shape += factor * wx.d[k] * wy.d[k];
    out.by_x += factor * wx.d[k + 1] * wy.d[k] * per_x;
    out.by_y += factor * wx.d[k] * wy.d[k + 1] * per_y;
    // The blurred wave obeys the heat equation, so a wider blur adds the second derivative.
    out.by_blur += factor * ((wx.d[k + 2] + power * wx.d[k]) * wy.d[k] + wx.d[k] * (wy.d[k + 2] + power * wy.d[k])) / blur_px;
    factor *= foot.correlation / (power + 1);
  }
  return out;
}

}  // namespace srd::dsp
