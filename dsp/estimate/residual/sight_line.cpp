// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/residual/sight_line.hpp"

namespace srd::dsp {

template bool sight(const Optics<Lanes<float>>&, const Coefficients<Lanes<float>>&, SightLine<Lanes<float>>&,
                    Basis<Lanes<float>>*, bool, Sighting<Lanes<float>>&);
template bool sight(const Optics<Lanes<double>>&, const Coefficients<Lanes<double>>&, SightLine<Lanes<double>>&,
                    Basis<Lanes<double>>*, bool, Sighting<Lanes<double>>&);

}  // namespace srd::dsp
