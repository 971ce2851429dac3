// SPDX-License-Identifier: Apache-2.0
// What a run found in one frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/pose/height_of_pose.hpp"
#include "proto/messages.hpp"

namespace srd::host {

struct FrameRecord {
  std::string name;            // file of the first camera's frame
  std::uint64_t sequence = 0;  // chronological, from 0 unless the recording says otherwise
  std::int64_t time_ns = 0;
  proto::FrameStatus status = proto::FrameStatus::kBadFrame;
  dsp::Estimate<double> estimate;           // meaningful when has_surface()
  int expected = 0;                         // points of all cameras together; pixels that show the pattern
  int found = 0;                            // corners of all cameras together; pixels used
  double seconds = 0;                       // spent on the frame, reading included
  std::optional<dsp::Vec2<double>> centre;  // of the surface seen in the region, X Y in mm; pattern metric only
  std::vector<std::vector<dsp::Observation<double>>> corners;  // a list a camera
  // What the errors of calibrations and poses leave alike in every frame; none: not known.
  std::optional<dsp::SystematicSurface> systematic{};

  [[nodiscard]] bool has_surface() const { return !dsp::failed(estimate.stop); }
};

}  // namespace srd::host
