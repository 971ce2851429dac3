// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/view.hpp"

namespace srd::dsp {

template struct View<float>;
template struct View<double>;

}  // namespace srd::dsp
