// SPDX-License-Identifier: Apache-2.0
#include "dsp/estimate/estimator/estimator_fit.hpp"

namespace srd::dsp {

template class SurfaceEstimator<float>;

}  // namespace srd::dsp
