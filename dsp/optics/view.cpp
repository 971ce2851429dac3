#include "dsp/optics/view.hpp"

namespace srd::dsp {

template struct View<float>;
template struct View<double>;

}  // namespace srd::dsp
