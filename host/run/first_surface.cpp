// SPDX-License-Identifier: Apache-2.0
#include "host/run/first_surface.hpp"

#include <algorithm>

namespace srd::host {

namespace {

// How many modes of total each step has.
std::vector<int> step_sizes(int total) {
  std::vector<int> sizes;
  for (const int size : {1, 3, 5, 8, 12})
    if (size < total) sizes.push_back(size);
  sizes.push_back(total);
  return sizes;
}

// The run's modes by how little they bend: level, slopes, then by the sum of their harmonics.
std::vector<int> by_bend(const dsp::ModeList& modes) {
  const auto bend = [](const dsp::Mode& mode) { return mode.kind == dsp::Mode::Kind::kCosine ? 10 * (mode.m + mode.n) : 1; };
  std::vector<int> order;
  for (int i = 0; i < modes.size(); ++i) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return bend(modes[a]) < bend(modes[b]); });
  return order;
}

std::vector<double> picked(const std::vector<double>& all, const std::vector<int>& places) {
  std::vector<double> some;
  if (!all.empty())
    for (const int place : places) some.push_back(all[static_cast<std::size_t>(place)]);
  return some;
}

}  // namespace

Result<FirstSurface> FirstSurface::make(const RunPlan& plan, int max_corners) {
  const std::vector<int> order = by_bend(plan.model.modes);
  FirstSurface first;
  for (const int size : step_sizes(plan.model.modes.size())) {
    const std::vector<int> places(order.begin(), order.begin() + size);
    std::vector<dsp::Mode> modes;
    for (const int place : places) modes.push_back(plan.model.modes[place]);
    dsp::SurfaceModel<double> model = plan.model;
    const auto list = dsp::ModeList::make(modes);
    if (!list) return list.error();
    model.modes = *list;
    dsp::EstimatorOptions options;
    options.metric = dsp::Metric::kDisparity;
    options.scale = picked(plan.options.scale, places);
    options.lower = picked(plan.options.lower, places);
    options.upper = picked(plan.options.upper, places);
    auto estimator = dsp::SurfaceEstimator<double>::make(model, plan.media, plan.points, options, max_corners);
    if (!estimator) return estimator.error();
    first.steps_.push_back({std::move(estimator).value(), places});
  }
  return first;
}

std::optional<FirstSurface::Found> FirstSurface::find(std::span<const dsp::CameraObservations<double>> cameras,
                                                      const dsp::Coefficients<double>& guess) {
  std::optional<Found> best;
  dsp::Coefficients<double> surface = guess;
  for (Step& step : steps_) {
    dsp::Coefficients<double> start(static_cast<Eigen::Index>(step.modes.size()));
    for (std::size_t j = 0; j < step.modes.size(); ++j) start[static_cast<Eigen::Index>(j)] = surface[step.modes[j]];
    const std::vector<dsp::Coefficients<double>> starts = {start};
    const auto found = step.estimator.estimate(cameras, starts);
    if (dsp::failed(found.stop)) continue;
    surface.setZero();
    for (std::size_t j = 0; j < step.modes.size(); ++j)
      surface[step.modes[j]] = found.coefficients[static_cast<Eigen::Index>(j)];
    best = Found{surface, found.reprojection_rms};
  }
  return best;
}

}  // namespace srd::host
