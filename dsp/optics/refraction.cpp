// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/refraction.hpp"

namespace srd::dsp {

template bool cross(const Vec3<float>&, float, float, float, const Media<float>&, bool, Crossing<float>&, bool);
template bool cross(const Vec3<double>&, double, double, double, const Media<double>&, bool, Crossing<double>&, bool);

}  // namespace srd::dsp
