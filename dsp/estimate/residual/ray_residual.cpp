// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/residual/ray_residual.hpp"

namespace srd::dsp {

template bool ray_residual(Metric, const Optics<Lanes<float>>&, const Coefficients<Lanes<float>>&,
                           PreparedCorner<Lanes<float>>&, Basis<Lanes<float>>*, CornerResidual<Lanes<float>>&,
                           Mat2<Lanes<float>>*);
template bool ray_residual(Metric, const Optics<Lanes<double>>&, const Coefficients<Lanes<double>>&,
                           PreparedCorner<Lanes<double>>&, Basis<Lanes<double>>*, CornerResidual<Lanes<double>>&,
                           Mat2<Lanes<double>>*);

}  // namespace srd::dsp
