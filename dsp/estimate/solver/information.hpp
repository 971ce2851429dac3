// SPDX-License-Identifier: Apache-2.0
// Square matrices over the parameters of a fit. Fixed capacity: no heap.
#pragma once

#include "dsp/optics/surface_model.hpp"

namespace srd::dsp {

template <class S>
using InformationMatrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters, kMaxParameters>;

}  // namespace srd::dsp
