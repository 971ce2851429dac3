// SPDX-License-Identifier: Apache-2.0
#include "host/pose/point_refinement.hpp"

#include <ceres/normal_prior.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/LU>
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "host/bundle/corner_costs.hpp"
#include "host/bundle/lens.hpp"
#include "host/bundle/rigid.hpp"

namespace srd::host {

namespace {

constexpr std::size_t kFewestViews = 2;
constexpr double kRefinedSigmaPx = 0.005;  // no corner is found better, optics (20)

struct RefinedView {
  ReferenceView view;
  BoardOrder order;
  bundle::PoseVector pose;
};

std::vector<double> intrinsics_of(const Calibration& calibration) {
  const auto& camera = calibration.camera;
  std::vector<double> numbers = {camera.fx(), camera.fy(), camera.cx(), camera.cy()};
  const std::size_t given = calibration.distortion.empty() ? 4 : calibration.distortion.size();
  for (std::size_t i = 0; i < given; ++i) numbers.push_back(camera.distortion()[i]);
  return numbers;
}

double rms_of(const Calibration& calibration, const std::vector<RefinedView>& views, const Points& points) {
  double sum = 0, n = 0;
  for (const RefinedView& each : views) {
    const dsp::View<double> view{calibration.camera, bundle::to_pose(each.pose)};
    for (std::size_t i = 0; i < each.view.corners.size(); ++i) {
      const auto seen = dsp::see_point(view, points[static_cast<std::size_t>(each.order.points[i])], nullptr);
      if (!seen) continue;
      sum += (seen->pixel - each.view.corners[i].pixel).squaredNorm();
      n += 2;
    }
  }
  return n > 0 ? std::sqrt(sum / n) : 0;
}

}  // namespace

Outcome<PointRefinement> refine_points(const MeasuredPose& reference, const std::vector<std::filesystem::path>& views,
                                       const PoseRequest& request, double expected_mm) {
  if (views.size() < kFewestViews)
    return Problem{Exit::kUsage,
                   "--view",
                   "srd pose",
                   formatted("at least %zu further views of the pattern", kFewestViews),
                   formatted("%zu", views.size()),
                   "add images from other places, some oblique"};
  std::vector<RefinedView> all;
  all.push_back({reference.view, reference.order, bundle::to_vector(reference.fit.pose)});
  for (const std::filesystem::path& file : views) {
    auto view = read_reference({file}, reference.calibration, reference.board, request.search);
    if (!view) return view.error();
    const auto order = order_of(*view, reference.points, reference.board, request.order, file.string());
    if (!order) return order.error();
    std::vector<dsp::PoseCorner> corners;
    for (std::size_t i = 0; i < view->corners.size(); ++i)
      corners.push_back(
          {reference.points[static_cast<std::size_t>(order->points[i])], view->corners[i].pixel, view->corners[i].sigma_px});
    const auto fit = fit_pose(reference.calibration, corners, file.string());
    if (!fit) return fit.error();
    all.push_back({std::move(view).value(), *order, bundle::to_vector(fit->pose)});
  }
  PointRefinement out;
  out.views = static_cast<int>(all.size());
  out.points = reference.points;
  out.before_px = rms_of(reference.calibration, all, reference.points);

  std::vector<double> lens = intrinsics_of(reference.calibration);
  const int coefficients = static_cast<int>(lens.size()) - bundle::kPinhole;
  ceres::Problem problem;
  problem.AddParameterBlock(lens.data(), static_cast<int>(lens.size()));
  problem.SetParameterBlockConstant(lens.data());
  const ceres::Matrix prior = ceres::Matrix::Identity(3, 3) / expected_mm;
  std::vector<Eigen::Matrix3d> information(out.points.size(), Eigen::Matrix3d::Identity() / (expected_mm * expected_mm));
  for (std::size_t i = 0; i < out.points.size(); ++i)
    problem.AddResidualBlock(new ceres::NormalPrior(prior, reference.points[i]), nullptr, out.points[i].data());
  struct Seen {
    bundle::PointCost* cost;
    double *pose, *point;
    std::size_t place;
  };
  std::vector<Seen> seen;
  for (RefinedView& each : all)
    for (std::size_t i = 0; i < each.view.corners.size(); ++i) {
      const BoardCorner& corner = each.view.corners[i];
      const auto place = static_cast<std::size_t>(each.order.points[i]);
      auto* cost = new bundle::PointCost({corner.pixel, std::hypot(corner.sigma_px, kRefinedSigmaPx)}, coefficients);
      seen.push_back({cost, each.pose.data(), out.points[place].data(), place});
      problem.AddResidualBlock(cost, nullptr, lens.data(), each.pose.data(), out.points[place].data());
    }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable())
    return Problem{Exit::kInput,
                   "the views give no points of the pattern",
                   views.front().string(),
                   "views that agree with one another",
                   summary.message.substr(0, 120),
                   "check that all show the same pattern"};
  for (const Seen& each : seen) {
    const double* blocks[] = {lens.data(), each.pose, each.point};
    double residuals[2];
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
    double* jacobians[] = {nullptr, nullptr, by_point.data()};
    if (each.cost->Evaluate(blocks, residuals, jacobians)) information[each.place] += by_point.transpose() * by_point;
  }
  double xy = 0, z = 0;
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    const dsp::Vec3<double> off = out.points[i] - reference.points[i];
    xy += off.head<2>().squaredNorm();
    z += off.z() * off.z();
    out.deviation.emplace_back(information[i].inverse().diagonal().cwiseSqrt());
  }
  const auto n = static_cast<double>(out.points.size());
  out.print_mm = std::sqrt(xy / (2 * n));
  out.print_z_mm = std::sqrt(z / n);
  out.after_px = rms_of(reference.calibration, all, out.points);
  // The prior is data too: 3 numbers a point, as many as are fitted.
  out.variance_factor = 2 * summary.final_cost / (2 * static_cast<double>(seen.size()) - 6.0 * out.views);
  return out;
}

}  // namespace srd::host
