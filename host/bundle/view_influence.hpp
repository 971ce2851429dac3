// SPDX-License-Identifier: Apache-2.0
// What each view says of the camera: how much of the information is its own, and how far it contradicts the others.
// Corners of one view that share an error (a board that flexes in the hand, motion, uneven light) contradict the other
// views by more than their own deviations allow; the factor over all views, optics (31), is what a stated error must grow by.
#pragma once

#include <vector>

#include "host/bundle/camera_problem.hpp"

namespace srd::bundle {

struct Influence {
  double share = 0;          // of the information on lens and bend, 0 to 1; the views' shares add up to 1
  double contradiction = 0;  // chi-square a parameter of what it says against all others; 1 on average for pure noise
  // How lens (and bend) would move without this view, px, and in units of the stated deviations before they grow.
  Eigen::VectorXd without;
  double moved = 0;  // the largest of these in deviations
};

struct Influences {
  std::vector<Influence> views;
  double factor = 1;       // mean contradiction
  double significant = 1;  // what pure noise exceeds once in 4000 times
};

// Normal equations of one view for lens and bend, its pose eliminated, for residuals of unit variance.
struct ReducedView {
  Eigen::MatrixXd information;
  Eigen::VectorXd score;  // Jacobian' residual
};

// At a fit, with the corners that it uses. place: the view's there.
[[nodiscard]] ReducedView reduced_view(const BoardShape& shape, const BoardView& view, const CameraFit& fit, std::size_t place);

// A view's information on lens and bend, for residuals of unit variance, its pose eliminated.
[[nodiscard]] Eigen::MatrixXd view_information(const BoardShape& shape, const BoardView& view, const CameraFit& fit,
                                               const PoseVector& pose);

// At a minimum of the weighted squares; variance_factor: of these. A free board counts as known. With S_g a view's
// information on lens and bend after its pose is eliminated, s_g its score and S the sum: E[s_g s_g'] is
// S_g - S_g S^-1 S_g for independent noise, so s_g' (that)^-1 s_g is chi-square of as many degrees as parameters.
[[nodiscard]] Influences influences(const BoardShape& shape, const std::vector<BoardView>& views, const CameraOptions& options,
                                    const Weighting& weighting, const CameraState& state, double variance_factor);

}  // namespace srd::bundle
