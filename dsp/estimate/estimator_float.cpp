#include "dsp/estimate/estimator_fit.hpp"

namespace srd::dsp {

template class SurfaceEstimator<float>;

}  // namespace srd::dsp
