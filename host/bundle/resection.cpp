// SPDX-License-Identifier: Apache-2.0
#include "host/bundle/resection.hpp"

#include <opencv2/calib3d.hpp>

#include "host/bundle/camera_problem.hpp"
#include "host/bundle/lens.hpp"

namespace srd::bundle {

Result<Resection> resect(const BoardShape& shape, const BoardView& view, const CameraFit& fit) {
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> image;
  for (const ViewCorner& corner : view.corners) {
    const Eigen::Vector3d p = shape.flat(corner.row, corner.column);
    object.emplace_back(p.x(), p.y(), p.z());
    image.emplace_back(corner.pixel.x(), corner.pixel.y());
  }
  const std::vector<double>& k = fit.intrinsics;
  cv::Vec3d turn, translation;
  try {
    if (!cv::solvePnP(object, image, cv::Matx33d(k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1),
                      std::vector<double>(k.begin() + kPinhole, k.end()), turn, translation) ||
        !(translation[2] > 0))
      return Errc::kNotConverged;
  } catch (const std::exception&) {
    return Errc::kNotConverged;
  }
  CameraState state;
  state.intrinsics = k;
  state.bend = fit.bend;
  state.poses.emplace_back();
  state.poses[0] << turn[0], turn[1], turn[2], translation[0], translation[1], translation[2];
  CameraOptions options;
  options.coefficients = fit.lens_size() - kPinhole;
  options.surface = Surface::kFlat;  // the bend stays as it is
  Weighting weighting;
  weighting.used = {std::vector<char>(view.corners.size(), 1)};
  weighting.added_px = fit.added_px;
  const std::vector<BoardView> views{view};
  const auto problem = make_problem(shape, views, options, weighting, state);
  problem->SetParameterBlockConstant(state.intrinsics.data());
  if (!minimise(*problem, state)) return Errc::kNotConverged;
  Resection found{state.poses[0], 0};
  const auto residuals = residuals_of(shape, views, state);
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    const double sigma2 = view.corners[i].sigma * view.corners[i].sigma + fit.added_px * fit.added_px;
    found.chi_square += residuals[0][i].squaredNorm() / sigma2;
  }
  return found;
}

Result<BoardView> place_part(const BoardShape& shape, const BoardView& part, int part_rows, int part_columns,
                             const CameraFit& fit, std::optional<bool> odd) {
  BoardView best;
  double least = 0;
  for (int row = 0; row + part_rows <= shape.rows; ++row)
    for (int column = 0; column + part_columns <= shape.columns; ++column) {
      if (odd && *odd != ((row + column) % 2 != 0)) continue;
      BoardView moved = part;
      for (ViewCorner& corner : moved.corners) {
        corner.row += row;
        corner.column += column;
      }
      const auto found = resect(shape, moved, fit);
      if (!found || (!best.corners.empty() && found->chi_square >= least)) continue;
      least = found->chi_square;
      best = std::move(moved);
    }
  if (best.corners.empty()) return Errc::kNotConverged;
  return best;
}

}  // namespace srd::bundle
