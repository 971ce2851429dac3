// SPDX-License-Identifier: Apache-2.0
// Index of refraction of water against air, where its equation holds. Optics (21): X. Quan and E. S. Fry, Empirical
// equation for the index of refraction of seawater, Applied Optics 34 (1995) 3477, equation 3.
#pragma once

#include "dsp/core/result.hpp"

namespace srd::dsp {

// Where the equation was fitted, to 1.5e-4; the wavelength is that in air.
struct WaterRange {
  double least, most;
};
inline constexpr WaterRange kWaterTemperatureC{0, 30};
inline constexpr WaterRange kWaterSalinityPerMille{0, 35};
inline constexpr WaterRange kWaterWavelengthNm{400, 700};

// 20 C, fresh, 589 nm: 1.3330. kInvalidArgument outside the ranges above, or for a NaN.
[[nodiscard]] inline Result<double> water_refractive_index(double temperature_c, double salinity_per_mille,
                                                           double wavelength_nm) {
  const auto inside = [](double x, const WaterRange& range) { return x >= range.least && x <= range.most; };
  if (!inside(temperature_c, kWaterTemperatureC) || !inside(salinity_per_mille, kWaterSalinityPerMille) ||
      !inside(wavelength_nm, kWaterWavelengthNm))
    return Errc::kInvalidArgument;
  const double t = temperature_c, s = salinity_per_mille, l = wavelength_nm;
  return 1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s - 2.02e-6 * t * t + (15.868 + 0.01155 * s - 0.00423 * t) / l -
         4382 / (l * l) + 1.1455e6 / (l * l * l);
}

}  // namespace srd::dsp
