// SPDX-License-Identifier: Apache-2.0
#include "host/run/systematic.hpp"

#include <algorithm>

namespace srd::host {

namespace {

// Corners by their deviations, or alike, as the fit of this metric counted them.
std::vector<dsp::CountedCorner> counted(const FrameRecord& frame) {
  std::vector<dsp::CountedCorner> corners;
  for (std::size_t c = 0; c < frame.corners.size(); ++c)
    for (const auto& corner : frame.corners[c]) corners.push_back({static_cast<int>(c), corner.point, corner.sigma});
  return corners;
}

}  // namespace

std::optional<ErrorSources> error_sources(const RunPlan& plan) {
  if (plan.pattern_run || plan.options.free_index || plan.cameras.size() > dsp::kMaxUnsureCameras) return std::nullopt;
  std::optional<ErrorSources> sources;
  for (const RunCamera& camera : plan.cameras) {
    if (!camera.errors) return std::nullopt;
    const KnownErrors& known = *camera.errors;
    if (!sources) {
      sources = ErrorSources{known.pose_date, known.calibration_date};
      continue;
    }
    sources->pose = std::min(sources->pose, known.pose_date);
    sources->calibration = sources->calibration && known.calibration_date
                               ? std::optional(std::min(*sources->calibration, *known.calibration_date))
                               : std::nullopt;
  }
  return sources;
}

void add_systematic(const RunPlan& plan, std::vector<FrameRecord>& frames) {
  if (!error_sources(plan)) return;
  std::vector<dsp::UnsurePose> cameras;
  for (const RunCamera& camera : plan.cameras)
    cameras.push_back({{camera.calibration.camera, camera.pose}, camera.errors->errors});
  for (FrameRecord& frame : frames) {
    if (!frame.has_surface()) continue;
    const dsp::WaterAbove water{plan.model, frame.estimate.coefficients.head(plan.model.modes.size()), plan.media};
    const auto surface = dsp::surface_of_poses(cameras, plan.points, water, counted(frame));
    if (surface) frame.systematic = *surface;
  }
}

}  // namespace srd::host
