// SPDX-License-Identifier: Apache-2.0
// Index of refraction of water against air, where its equation holds. Optics (21).
#pragma once

#include "dsp/core/result.hpp"
#include "dsp/optics/water_index.hpp"

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
  return water_index(temperature_c, salinity_per_mille, wavelength_nm);
}

}  // namespace srd::dsp
