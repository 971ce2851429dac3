// SPDX-License-Identifier: Apache-2.0
// Several boards' estimates of one surface, added as information. Optics (18) with the maps of (40).
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "host/fusion/board_track.hpp"
#include "host/fusion/common_surface.hpp"

namespace srd::host {

// What one board says of the common coefficients: Lambda (1/mm^2) and Lambda a.
struct Contribution {
  Eigen::MatrixXd information;
  Eigen::VectorXd weighted;
};

// about: common coefficients near the truth, by which the doubt of an inexact map is scaled; empty: not known yet, and the
// map's doubt is taken for waves of 1 mm. nullopt: the covariance is not positive definite.
[[nodiscard]] std::optional<Contribution> contribution_of(const TimedSurface& board, const BoardMap& map,
                                                          const Eigen::VectorXd& about);

struct FusedSurface {
  Eigen::VectorXd coefficients;  // mm
  Eigen::MatrixXd information;   // 1/mm^2
  Eigen::MatrixXd covariance;    // mm^2
};
// nullopt: together they do not determine the surface.
[[nodiscard]] std::optional<FusedSurface> add_information(std::span<const Contribution* const> parts, Eigen::Index modes);

}  // namespace srd::host
