// SPDX-License-Identifier: Apache-2.0
#include "dsp/pipeline/prediction.hpp"

namespace srd::dsp {

template Result<Prediction<float>> predict(const View<float>&, const SurfaceModel<float>&, const Coefficients<float>&,
                                           const Media<float>&, const Vec3<float>&, const Vec2<float>&);
template Result<Prediction<double>> predict(const View<double>&, const SurfaceModel<double>&, const Coefficients<double>&,
                                            const Media<double>&, const Vec3<double>&, const Vec2<double>&);
template CornerShape expected_shape(const Prediction<float>&, bool, std::int32_t);
template CornerShape expected_shape(const Prediction<double>&, bool, std::int32_t);
template bool is_bright(const Prediction<float>&, const CornerShape&);
template bool is_bright(const Prediction<double>&, const CornerShape&);

}  // namespace srd::dsp
