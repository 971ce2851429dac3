// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/view_influence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "host/bundle/chi_square.hpp"
#include "host/bundle/corner_costs.hpp"
#include "host/bundle/lens.hpp"

namespace srd::bundle {

namespace {

constexpr double kUnlikely = 3.5;  // of a normal number: once in 4300

// As ReducedView has it, about a state.
ReducedView reduce(const BoardShape& shape, const BoardView& view, const std::vector<char>& used, const CameraOptions& options,
                   double added_px, const CameraState& state, const PoseVector& pose) {
  const bool bent = options.surface == Surface::kBent, free = options.surface == Surface::kFree;
  const int lens = static_cast<int>(state.intrinsics.size()), n = lens + (bent ? kBend : 0);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n), b = Eigen::MatrixXd::Zero(n, kPose);
  Eigen::Matrix<double, kPose, kPose> c = Eigen::Matrix<double, kPose, kPose>::Zero();
  Eigen::VectorXd score = Eigen::VectorXd::Zero(n);
  PoseVector pose_score = PoseVector::Zero();
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> by_lens(2, lens), by_shared(2, n);
  Eigen::Matrix<double, 2, kPose, Eigen::RowMajor> by_pose;
  Eigen::Matrix<double, 2, kBend, Eigen::RowMajor> by_bend;
  Eigen::Vector2d residual;
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    if (used[i] == 0) continue;
    const ViewCorner& corner = view.corners[i];
    const SeenCorner seen{corner.pixel, std::hypot(corner.sigma, added_px)};
    std::array<double*, 3> into{by_lens.data(), by_pose.data(), bent ? by_bend.data() : nullptr};
    const double* board =
        free ? state.points[static_cast<std::size_t>(corner.row * shape.columns + corner.column)].data() : state.bend.data();
    const std::array<const double*, 3> at{state.intrinsics.data(), pose.data(), board};
    const bool good = free ? PointCost(seen, options.coefficients).Evaluate(at.data(), residual.data(), into.data())
                           : BoardCost(seen, options.coefficients, shape, corner.row, corner.column)
                                 .Evaluate(at.data(), residual.data(), into.data());
    if (!good) continue;
    by_shared.leftCols(lens) = by_lens;
    if (bent) by_shared.rightCols<kBend>() = by_bend;
    a.noalias() += by_shared.transpose() * by_shared;
    b.noalias() += by_shared.transpose() * by_pose;
    c.noalias() += by_pose.transpose() * by_pose;
    score.noalias() += by_shared.transpose() * residual;
    pose_score.noalias() += by_pose.transpose() * residual;
  }
  const auto pose_part = c.ldlt();
  return {a - b * pose_part.solve(b.transpose()), score - b * pose_part.solve(pose_score)};
}

ReducedView reduce_at(const BoardShape& shape, const BoardView& view, const std::vector<char>& used, const CameraFit& fit,
                      const PoseVector& pose) {
  CameraOptions options;
  options.coefficients = fit.lens_size() - kPinhole;
  options.surface = fit.surface;
  CameraState state;
  state.intrinsics = fit.intrinsics;
  state.bend = fit.bend;
  state.points = fit.points;
  return reduce(shape, view, used, options, fit.added_px, state, pose);
}

// x' M^+ x over the eigenvalues that stand out of rounding, and how many these are.
std::pair<double, int> quadratic(const Eigen::MatrixXd& m, const Eigen::VectorXd& x) {
  const Eigen::VectorXd unit = m.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(unit.asDiagonal() * m * unit.asDiagonal());
  const Eigen::VectorXd along = solver.eigenvectors().transpose() * unit.asDiagonal() * x;
  double sum = 0;
  int rank = 0;
  for (Eigen::Index i = 0; i < along.size(); ++i) {
    if (solver.eigenvalues()[i] < 1e-9) continue;
    sum += along[i] * along[i] / solver.eigenvalues()[i];
    ++rank;
  }
  return {sum, rank};
}

}  // namespace

Eigen::MatrixXd view_information(const BoardShape& shape, const BoardView& view, const CameraFit& fit, const PoseVector& pose) {
  return reduce_at(shape, view, std::vector<char>(view.corners.size(), 1), fit, pose).information;
}

ReducedView reduced_view(const BoardShape& shape, const BoardView& view, const CameraFit& fit, std::size_t place) {
  return reduce_at(shape, view, fit.views[place].used, fit, fit.views[place].pose);
}

Influences influences(const BoardShape& shape, const std::vector<BoardView>& views, const CameraOptions& options,
                      const Weighting& weighting, const CameraState& state, double variance_factor) {
  std::vector<ReducedView> reduced;
  for (std::size_t v = 0; v < views.size(); ++v)
    reduced.push_back(reduce(shape, views[v], weighting.used[v], options, weighting.added_px, state, state.poses[v]));
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(reduced[0].information.rows(), reduced[0].information.cols());
  for (const ReducedView& view : reduced) all += view.information;
  const Eigen::LDLT<Eigen::MatrixXd> whole(all);
  const Eigen::VectorXd deviation =
      (variance_factor * whole.solve(Eigen::MatrixXd::Identity(all.rows(), all.cols())).diagonal()).cwiseMax(0).cwiseSqrt();
  Influences found;
  double sum = 0;
  int degrees = 0;
  for (const ReducedView& view : reduced) {
    Influence& influence = found.views.emplace_back();
    const Eigen::MatrixXd portion = whole.solve(view.information);
    influence.share = portion.trace() / static_cast<double>(all.rows());
    const auto [square, rank] = quadratic(view.information - view.information * portion, view.score);
    if (rank > 0) influence.contradiction = square / (variance_factor * rank);
    sum += square / variance_factor;
    degrees += rank;
    influence.without = Eigen::LDLT<Eigen::MatrixXd>(all - view.information).solve(view.score);
    influence.moved = influence.without.cwiseQuotient(deviation).cwiseAbs().maxCoeff();
  }
  if (degrees == 0) return found;
  found.factor = sum / degrees;
  // The scores add up to nothing, so one view's worth of them is not free.
  const int free = std::max(degrees - static_cast<int>(all.rows()), 1);
  found.significant = chi_square_limit(free, kUnlikely) / free;
  return found;
}

}  // namespace srd::bundle
