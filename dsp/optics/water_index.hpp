// SPDX-License-Identifier: Apache-2.0
// Refractive index of water against air. Optics (21): X. Quan and E. S. Fry, Empirical equation for the index of
// refraction of seawater, Applied Optics 34 (1995) 3477, equation 3.
#pragma once

namespace srd::dsp {

// Fitted for temperature 0..30 degrees C, salinity 0..35 per mille, wavelength 400..700 nm (in air), to 1.5e-4; not
// checked here.
[[nodiscard]] constexpr double water_index(double temperature_c, double salinity_per_mille, double wavelength_nm) {
  const double t = temperature_c, s = salinity_per_mille, l = wavelength_nm;
  return 1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s - 2.02e-6 * t * t + (15.868 + 0.01155 * s - 0.00423 * t) / l -
         4382 / (l * l) + 1.1455e6 / (l * l * l);
}

}  // namespace srd::dsp
