// SPDX-License-Identifier: Apache-2.0
#include "dsp/optics/ray_trace.hpp"

namespace srd::dsp {

template Result<float> intersect(const Ray<float>&, const SurfaceModel<float>&, const Coefficients<float>&, float,
                                 SurfaceSample<float>&);
template Result<double> intersect(const Ray<double>&, const SurfaceModel<double>&, const Coefficients<double>&, double,
                                  SurfaceSample<double>&);
template Result<void, Errc> trace(const Ray<float>&, const SurfaceModel<float>&, const Coefficients<float>&,
                                  const Media<float>&, float, bool, Trace<float>&, float);
template Result<void, Errc> trace(const Ray<double>&, const SurfaceModel<double>&, const Coefficients<double>&,
                                  const Media<double>&, double, bool, Trace<double>&, double);
template Result<Vec2<float>> see_through(const View<float>&, const SurfaceModel<float>&, const Coefficients<float>&,
                                         const Media<float>&, const Vec3<float>&, Vec2<float>, Trace<float>&, Mat2<float>&);
template Result<Vec2<double>> see_through(const View<double>&, const SurfaceModel<double>&, const Coefficients<double>&,
                                          const Media<double>&, const Vec3<double>&, Vec2<double>, Trace<double>&,
                                          Mat2<double>&);

}  // namespace srd::dsp
