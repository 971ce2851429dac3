// SPDX-License-Identifier: Apache-2.0
// The estimator's answer as part of a frame's record.
#pragma once

#include "dsp/estimate/estimator.hpp"
#include "proto/messages.hpp"

namespace srd::proto {

// Fills what the estimate says: coefficients, information, errors, stop, status; the rest of the record is the caller's.
// An answer that is not finite counts as none. status afterwards: kOk, kNotConverged, kTooFewCorners or kFailed.
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
  if (dsp::failed(estimate.stop) || !numbers) {
    frame.status = estimate.stop == dsp::Stop::kTooFewCorners ? FrameStatus::kTooFewCorners : FrameStatus::kFailed;
    return;
  }
  const bool unfinished = estimate.stop == dsp::Stop::kMaxIterations || estimate.stop == dsp::Stop::kDeadline;
  frame.status = unfinished ? FrameStatus::kNotConverged : FrameStatus::kOk;
  frame.coefficients = estimate.coefficients.template cast<float>();
  if (!quantise(estimate.information, frame.information)) frame.information = InformationFactor{};
  frame.mean_error = static_cast<float>(estimate.mean_error);
  frame.reprojection_rms_px = static_cast<float>(estimate.reprojection_rms);
}

}  // namespace srd::proto
