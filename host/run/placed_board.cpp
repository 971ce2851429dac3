// SPDX-License-Identifier: Apache-2.0
#include "host/run/placed_board.hpp"

#include "host/run/identities.hpp"

namespace srd::host {

std::optional<std::vector<dsp::Observation<double>>> placed_board(const RunPlan& plan, const RunCamera& camera,
                                                                  std::span<const BoardCorner> corners) {
  std::vector<ListedCorner> listed;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto xy = camera.calibration.camera.undistort(corners[i].pixel);
    if (!xy) return std::nullopt;
    listed.push_back({static_cast<int>(i), *xy});
  }
  const bool from_end = counts_from_end(listed, camera, plan.points);
  std::vector<dsp::Observation<double>> observed;
  for (std::size_t i = 0; i < listed.size(); ++i)
    observed.push_back({point_at(camera, listed[i].place, from_end), corners[i].pixel, listed[i].normalised, 1.0});
  return observed;
}

}  // namespace srd::host
