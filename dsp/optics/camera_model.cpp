// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/camera_model.hpp"

namespace srd::dsp {

template class CameraModel<float>;
template class CameraModel<double>;

}  // namespace srd::dsp
