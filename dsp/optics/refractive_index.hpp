// Index of refraction of water against air. Optics (21): X. Quan and E. S. Fry, Empirical equation for the index of
// refraction of seawater, Applied Optics 34 (1995) 3477.
#pragma once

#include "dsp/core/result.hpp"

namespace srd::dsp {

// Where the equation was fitted.
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
  const double t = temperature_c, s = salinity_per_mille, per_l = 1 / wavelength_nm;
  return 1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s - 2.02e-6 * t * t +
         per_l * (15.868 + 0.01155 * s - 0.00423 * t + per_l * (-4382 + per_l * 1.1455e6));
}

}  // namespace srd::dsp
