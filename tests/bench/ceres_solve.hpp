// SPDX-License-Identifier: Apache-2.0
// The baseline of the solve: the same reprojection residuals, px, minimised by Ceres with automatic derivatives.
#pragma once

#include <memory>
#include <span>

#include "dsp/estimate/residual/observation.hpp"
#include "dsp/optics/media.hpp"
#include "dsp/optics/surface_model.hpp"

namespace srd::bench {

class CeresSolve {
 public:
  // model: 12 modes. The problem is built once: what solve() takes is the solution alone.
  CeresSolve(const dsp::View<double>& view, const dsp::SurfaceModel<double>& model, const dsp::Media<double>& media,
             std::span<const dsp::Vec3<double>> points, std::span<const dsp::Observation<double>> corners);
  ~CeresSolve();
  // coefficients: start and result. The sum of squared weighted residuals; NaN for a failure.
  double solve(dsp::Coefficients<double>& coefficients);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace srd::bench
