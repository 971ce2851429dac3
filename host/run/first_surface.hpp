// SPDX-License-Identifier: Apache-2.0
// A surface to start from when nothing is known but a guess: level first, then plane, then ever more modes, each from the
// one before. A full model started far off can end at a wrong depth; a level does not.
#pragma once

#include <optional>
#include <vector>

#include "host/run/run.hpp"

namespace srd::host {

class FirstSurface {
 public:
  // model, media, points, options: of the run. The metric is disparity, whatever options say: it leads to the right depth.
  [[nodiscard]] static Result<FirstSurface> make(const RunPlan& plan, int max_corners);

  struct Found {
    dsp::Coefficients<double> coefficients;  // in the modes of the run
    double reprojection_rms = 0;             // px, per axis
  };
  // Nothing when no step gave a surface.
  [[nodiscard]] std::optional<Found> find(std::span<const dsp::CameraObservations<double>> cameras,
                                          const dsp::Coefficients<double>& guess);

 private:
  struct Step {
    dsp::SurfaceEstimator<double> estimator;
    std::vector<int> modes;  // of the step, as places in the run's list
  };
  std::vector<Step> steps_;
};

}  // namespace srd::host
