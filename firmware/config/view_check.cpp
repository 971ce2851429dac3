// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/view_check.hpp"

#include <vector>

#include "drivers/support/rank_text.hpp"
#include "dsp/optics/ray_trace.hpp"

namespace srd::firmware {

std::string check_view(const NodeConfig& config, const dsp::View<double>& view, const dsp::SurfaceModel<double>& model,
                       const dsp::Media<double>& media, std::span<const dsp::Vec3<double>> points, int width, int height) {
  dsp::Coefficients<double> guess(model.modes.size());
  for (int i = 0; i < model.modes.size(); ++i) guess[i] = config.guess[static_cast<std::size_t>(i)];
  const Region seen = config.region.empty() ? Region{0, 0, width, height} : config.region;
  std::vector<dsp::Observation<double>> corners;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto dry = view.normalised(points[i]);
    if (!dry) continue;
    dsp::Trace<double> trace;
    dsp::Mat2<double> b_xy;
    const auto xy = dsp::see_through(view, model, guess, media, points[i], *dry, trace, b_xy);
    if (!xy) continue;
    dsp::Observation<double> corner;
    corner.point = static_cast<int>(i);
    corner.pixel = view.camera.pixel(*xy);
    corner.normalised = *xy;
    if (corner.pixel.x() < seen.u0 || corner.pixel.x() > seen.u1 || corner.pixel.y() < seen.v0 || corner.pixel.y() > seen.v1)
      continue;
    corners.push_back(corner);
  }
  std::string text;
  if (corners.size() < points.size())
    text += "warning   at the guess, " + std::to_string(corners.size()) + " of " + std::to_string(points.size()) +
            " corners lie in the image or region\n";
  dsp::EstimatorOptions options;
  options.metric = config.estimator.metric;
  options.lower = config.estimator.lower;
  options.upper = config.estimator.upper;
  auto estimator = dsp::SurfaceEstimator<double>::make(model, media, points, options, static_cast<int>(points.size()));
  if (!estimator || corners.empty()) return text;
  const dsp::CameraObservations<double> camera{&view, corners};
  const auto found = estimator->estimate(std::span(&camera, 1), std::span(&guess, 1));
  if (found.stop == dsp::Stop::kTooFewCorners)
    text += "warning   too few corners for " + std::to_string(model.modes.size()) + " coefficients\n";
  if (found.rank.n_dependences > 0) text += "warning   " + rank_text(found.rank, model.modes) + "\n";
  return text;
}

}  // namespace srd::firmware
