// SPDX-License-Identifier: Apache-2.0
// What the estimator and the tracker found, as part of a frame's record: the only place that turns their answers into a
// FrameStatus. Used by the node, srd reconstruct and the benchmarks.
#pragma once

#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/pipeline/surface_tracker.hpp"
#include "proto/messages.hpp"

namespace srd::proto {

// Of a fit by itself: kOk, kNotConverged (a surface, the best so far), kTooFewCorners or kFailed.
[[nodiscard]] constexpr FrameStatus status_of(dsp::Stop stop) {
  if (stop == dsp::Stop::kTooFewCorners) return FrameStatus::kTooFewCorners;
  if (dsp::failed(stop)) return FrameStatus::kFailed;
  return stop == dsp::Stop::kMaxIterations || stop == dsp::Stop::kDeadline ? FrameStatus::kNotConverged : FrameStatus::kOk;
}

// Of a tracked frame: what the tracker says of a surface counts more than what the estimate says of itself.
template <class S>
[[nodiscard]] FrameStatus status_of(const dsp::FrameResult<S>& result) {
  using dsp::TrackStatus;
  switch (result.status) {
    case TrackStatus::kOk: return status_of(result.estimate.stop);
    case TrackStatus::kNoPattern: return result.state == dsp::TrackState::kLost ? FrameStatus::kLost : FrameStatus::kSearching;
    case TrackStatus::kTooFewCorners: return FrameStatus::kTooFewCorners;
    case TrackStatus::kAmbiguous: return FrameStatus::kAmbiguous;
    case TrackStatus::kPoorFit: return FrameStatus::kPoorFit;
    case TrackStatus::kInconsistent: return FrameStatus::kInconsistent;
    case TrackStatus::kInterlaced: return FrameStatus::kInterlaced;
    case TrackStatus::kSolverFailed: return FrameStatus::kFailed;
    case TrackStatus::kBadImage: return FrameStatus::kBadFrame;
  }
  return FrameStatus::kFailed;
}

// Fills what the estimate says: coefficients, information, errors, stop, status; the rest of the record is the caller's.
// An answer that is not finite counts as none.
template <class S>
void set_estimate(const dsp::Estimate<S>& estimate, dsp::Metric metric, CoefficientFrame& frame) {
  frame.metric = metric;
  frame.stop = estimate.stop;
  frame.at_bound = estimate.at_bound;
  frame.iterations = static_cast<std::uint32_t>(estimate.iterations);
  frame.corners_used = static_cast<std::uint32_t>(estimate.corners_used);
  frame.coefficients.resize(0);
  frame.information = InformationFactor{};
  frame.mean_error = 0;
  frame.reprojection_rms_px = 0;
  const bool numbers = estimate.coefficients.size() == frame.model.modes.size() && estimate.coefficients.allFinite() &&
                       std::isfinite(estimate.mean_error) && std::isfinite(estimate.reprojection_rms);
  frame.status = status_of(estimate.stop);
  if (dsp::failed(estimate.stop)) return;
  if (!numbers) {
    frame.status = FrameStatus::kFailed;
    return;
  }
  frame.coefficients = estimate.coefficients.template cast<float>();
  if (!quantise(estimate.information, frame.information)) frame.information = InformationFactor{};
  frame.mean_error = static_cast<float>(estimate.mean_error);
  frame.reprojection_rms_px = static_cast<float>(estimate.reprojection_rms);
}

}  // namespace srd::proto
