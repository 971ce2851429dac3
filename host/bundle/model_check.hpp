// SPDX-License-Identifier: Apache-2.0
// Does the model fit? Both halves of the views calibrated alone, and a bend where none was in the model.
#pragma once

#include <optional>

#include "host/bundle/camera_solve.hpp"

namespace srd::bundle {

struct ModelCheck {
  bool fits = true;
  // Every second view against the others; absent where a half alone gives no calibration (fewer than 6 views).
  std::optional<CameraFit> even, odd;
  double halves = 0, halves_limit = 0;  // chi-square of lens and bend between the halves; what chance exceeds once in 1000
  // A flat model against a bent one: the bend that is found, mm, and its chi-square, 2 degrees of freedom.
  Eigen::Vector2d bend = Eigen::Vector2d::Zero();
  double bend_significance = 0, bend_limit = 0;  // limit: what chance exceeds once in 10000
  [[nodiscard]] bool halves_agree() const { return halves <= halves_limit; }
  [[nodiscard]] bool bend_missing() const { return bend_significance > bend_limit; }
};

[[nodiscard]] ModelCheck check_model(const BoardShape& shape, const std::vector<BoardView>& views, int image_width,
                                     int image_height, const CameraOptions& options, const CameraFit& fit);

}  // namespace srd::bundle
