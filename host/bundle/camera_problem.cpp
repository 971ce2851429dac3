// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/camera_problem.hpp"

#include <ceres/loss_function.h>
#include <ceres/ordered_groups.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <cmath>

#include "host/bundle/corner_costs.hpp"
#include "host/bundle/lens.hpp"

namespace srd::bundle {

namespace {

constexpr int kMaxIterations = 200;

// A corner of a free board against where a bent board has it. Blocks: point, bend.
class PriorCost : public ceres::SizedCostFunction<3, 3, kBend> {
 public:
  PriorCost(const BoardShape& shape, int row, int column, const CameraOptions& options)
      : flat_(shape.flat(row, column)),
        weights_(shape.bend_weights(row, column)),
        scale_(1 / options.print_mm, 1 / options.print_mm, 1 / options.unevenness_mm) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> point(parameters[0]);
    const Eigen::Map<const Eigen::Vector2d> bend(parameters[1]);
    const Eigen::Vector3d bent = flat_ + Eigen::Vector3d(0, 0, bend.dot(weights_));
    Eigen::Map<Eigen::Vector3d>{residuals} = scale_.cwiseProduct(point - bent);
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{jacobians[0]} = scale_.asDiagonal();
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, kBend, Eigen::RowMajor>> j(jacobians[1]);
      j.setZero();
      j.row(2) = -scale_.z() * weights_.transpose();
    }
    return true;
  }

 private:
  Eigen::Vector3d flat_;
  Eigen::Vector2d weights_;
  Eigen::Vector3d scale_;
};

std::size_t place(const BoardShape& shape, int row, int column) {
  return static_cast<std::size_t>(row * shape.columns + column);
}

}  // namespace

std::unique_ptr<ceres::Problem> make_problem(const BoardShape& shape, const std::vector<BoardView>& views,
                                             const CameraOptions& options, const Weighting& weighting, CameraState& state) {
  ceres::Problem::Options owning;
  owning.disable_all_safety_checks = true;
  auto problem = std::make_unique<ceres::Problem>(owning);
  const bool free = options.surface == Surface::kFree;
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t c = 0; c < views[v].corners.size(); ++c) {
      if (weighting.used[v][c] == 0) continue;
      const ViewCorner& corner = views[v].corners[c];
      const SeenCorner seen{corner.pixel, std::hypot(corner.sigma, weighting.added_px)};
      ceres::LossFunction* loss = weighting.robust > 0 ? new ceres::CauchyLoss(weighting.robust) : nullptr;
      if (free)
        problem->AddResidualBlock(new PointCost(seen, options.coefficients), loss, state.intrinsics.data(),
                                  state.poses[v].data(), state.points[place(shape, corner.row, corner.column)].data());
      else
        problem->AddResidualBlock(new BoardCost(seen, options.coefficients, shape, corner.row, corner.column), loss,
                                  state.intrinsics.data(), state.poses[v].data(), state.bend.data());
    }
  }
  if (free)
    for (int row = 0; row < shape.rows; ++row)
      for (int column = 0; column < shape.columns; ++column)
        problem->AddResidualBlock(new PriorCost(shape, row, column, options), nullptr,
                                  state.points[place(shape, row, column)].data(), state.bend.data());
  if (options.surface != Surface::kBent) problem->SetParameterBlockConstant(state.bend.data());
  return problem;
}

std::vector<Block> blocks_of(CameraState& state, Surface surface) {
  std::vector<Block> blocks{{state.intrinsics.data(), static_cast<int>(state.intrinsics.size())}};
  for (PoseVector& pose : state.poses) blocks.push_back({pose.data(), kPose});
  if (surface == Surface::kBent) blocks.push_back({state.bend.data(), kBend});
  if (surface == Surface::kFree)
    for (Eigen::Vector3d& point : state.points) blocks.push_back({point.data(), 3});
  return blocks;
}

Result<int> minimise(ceres::Problem& problem, CameraState& state) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  std::vector<double*> blocks;
  problem.GetParameterBlocks(&blocks);
  for (double* block : blocks) options.linear_solver_ordering->AddElementToGroup(block, 1);
  for (PoseVector& pose : state.poses)
    if (problem.HasParameterBlock(pose.data())) options.linear_solver_ordering->AddElementToGroup(pose.data(), 0);
  options.max_num_iterations = kMaxIterations;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-11;
  options.gradient_tolerance = 1e-12;
  options.num_threads = 1;  // the same sums in the same order on every machine
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable() || !std::isfinite(summary.final_cost)) return Errc::kNotConverged;
  return static_cast<int>(summary.iterations.size());
}

std::vector<std::vector<Eigen::Vector2d>> residuals_of(const BoardShape& shape, const std::vector<BoardView>& views,
                                                       const CameraState& state) {
  std::vector<std::vector<Eigen::Vector2d>> all(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    const dsp::Pose<double> pose = to_pose(state.poses[v]);
    for (const ViewCorner& corner : views[v].corners) {
      const Eigen::Vector3d point = state.points.empty() ? shape.bent(corner.row, corner.column, state.bend)
                                                         : state.points[place(shape, corner.row, corner.column)];
      Eigen::Vector2d pixel(1e9, 1e9);
      (void)project(state.intrinsics, pose.rotation * point + pose.translation, pixel);
      all[v].push_back(pixel - corner.pixel);
    }
  }
  return all;
}

}  // namespace srd::bundle
