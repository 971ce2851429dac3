// SPDX-License-Identifier: Apache-2.0
// A synthetic scene as an estimator of scalar S takes it.
#pragma once

#include <deque>
#include <vector>

#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/estimate/residual/metric.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::dsp {

inline constexpr double kCornerNoise = 0.1;  // px

template <class S>
struct Fit {
  fakes::Scene scene;
  EstimatorOptions options;
  std::vector<View<S>> views{};
  std::deque<std::vector<Observation<S>>> seen{};

  Fit(fakes::Scene the_scene, EstimatorOptions the_options) : scene(std::move(the_scene)), options(std::move(the_options)) {
    for (const auto& view : scene.views) views.push_back(view.template cast<S>());
  }

  void observe(double noise_px = 0, std::mt19937_64* random = nullptr) {
    seen.clear();
    for (std::size_t i = 0; i < views.size(); ++i) seen.push_back(scene.observe<S>(i, noise_px, random));
  }

  [[nodiscard]] SurfaceEstimator<S> estimator() const {
    std::vector<Vec3<S>> points;
    for (const auto& point : scene.points) points.push_back(point.cast<S>());
    return SurfaceEstimator<S>::make(scene.model.cast<S>(), scene.media.cast<S>(), points, options, 2000).value();
  }

  [[nodiscard]] std::vector<CameraObservations<S>> cameras() const {
    std::vector<CameraObservations<S>> out;
    for (std::size_t i = 0; i < views.size(); ++i) out.push_back({&views[i], seen[i]});
    return out;
  }

  [[nodiscard]] Estimate<S> from(const Coefficients<double>& start) {
    if (seen.empty()) observe();
    const Coefficients<S> narrow = start.cast<S>();
    const auto all = cameras();
    return estimator().estimate(all, std::span(&narrow, 1));
  }

  // From a flat surface 5 mm too high.
  [[nodiscard]] Estimate<S> from_flat() { return from(fakes::level(scene.parameters(), scene.truth[0] + 5)); }
};

}  // namespace srd::dsp
