// SPDX-License-Identifier: Apache-2.0
#include "host/pose/measured_pose.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/support/formatted.hpp"
#include "drivers/support/text_file.hpp"
#include "dsp/pipeline/pattern.hpp"

namespace srd::host {

namespace {

constexpr double kNotableCorrelation = 0.3;

// Of residuals of neighbours along rows and columns, both components together.
double correlation_of_neighbours(const std::vector<dsp::Vec2<double>>& left, PatternSize seen) {
  double products = 0, squares = 0;
  int pairs = 0;
  const auto at = [&](int r, int c) { return left[static_cast<std::size_t>(r * seen.columns + c)]; };
  for (int r = 0; r < seen.rows; ++r)
    for (int c = 0; c < seen.columns; ++c) {
      squares += at(r, c).squaredNorm() / static_cast<double>(seen.count());
      if (c + 1 < seen.columns) products += at(r, c).dot(at(r, c + 1)), ++pairs;
      if (r + 1 < seen.rows) products += at(r, c).dot(at(r + 1, c)), ++pairs;
    }
  return squares > 0 && pairs > 0 ? products / pairs / squares : 0;
}

}  // namespace

const dsp::WaterAbove* StillWater::above() {
  if (!wet() && media.n_layers == 0) return nullptr;
  above_.model.modes = dsp::ModeList::standard(1).value();
  above_.media = media;
  if (!wet()) above_.media.water = media.air;  // plates under air: any level above them does
  above_.surface = dsp::Coefficients<double>::Constant(1, level_mm.value_or(media.plates() + 1));
  return &above_;
}

Outcome<NamedPattern> named_pattern(const PoseRequest& request) {
  if (!request.points_file) {
    if (!request.board || !request.square_mm)
      return Problem{Exit::kUsage,
                     "no pattern",
                     "srd pose",
                     "--pattern POINTS.txt, or --board ROWSxCOLUMNS and --square-mm MM",
                     request.board ? "no --square-mm" : "no --board",
                     ""};
    return NamedPattern{board_points(*request.board, *request.square_mm), *request.board, *request.square_mm};
  }
  const std::string where = request.points_file->string();
  if (request.square_mm)
    return Problem{Exit::kUsage, "--pattern and --square-mm exclude each other",
                   where,        "one of them",
                   "both",       "the points' file has the lengths"};
  const Outcome<Points> points = read_points(*request.points_file);
  if (!points) return points.error();
  const auto pattern = dsp::Pattern::make(*points, dsp::FirstSquare::kUnknown);
  // Rows may run along X or along Y: a row ends where the list jumps back.
  PatternSize board;
  if (pattern && pattern->rows() > 1 && pattern->columns() > 1) {
    const bool rows_along_x = pattern->row(1) == pattern->row(0);
    board = rows_along_x ? PatternSize{pattern->rows(), pattern->columns()} : PatternSize{pattern->columns(), pattern->rows()};
    bool listed = board.count() == static_cast<int>(points->size());
    for (int i = 1; listed && i < pattern->size(); ++i) {
      const int across = rows_along_x ? pattern->row(i) - pattern->row(i - 1) : pattern->column(i) - pattern->column(i - 1);
      const int along = rows_along_x ? pattern->column(i) - pattern->column(i - 1) : pattern->row(i) - pattern->row(i - 1);
      const bool ends = i % board.columns == 0;
      listed = ends ? std::abs(across) == 1 : across == 0 && std::abs(along) == 1;
    }
    if (!listed) board = {};
  }
  if (board.count() == 0)
    return Problem{Exit::kInput,
                   "is not a pattern's list of points",
                   where,
                   "all corners of a checkerboard, row by row, on a square grid along X and Y",
                   std::to_string(points->size()) + " points that are none",
                   "write one with --board and --square-mm"};
  if (request.board && (request.board->rows != board.rows || request.board->columns != board.columns))
    return Problem{Exit::kInput,
                   "is not the board that --board names",
                   where,
                   formatted("%d rows of %d", request.board->rows, request.board->columns),
                   formatted("%d rows of %d", board.rows, board.columns),
                   "leave --board out: the file says it"};
  return NamedPattern{*points, board, pattern->square()};
}

Outcome<MeasuredPose> measure_pose(PoseRequest request) {
  MeasuredPose out;
  auto pattern = named_pattern(request);
  if (!pattern) return pattern.error();
  out.points = std::move(pattern->points);
  out.board = pattern->board;
  out.square_mm = pattern->square_mm;
  const Outcome<Calibration> calibration = read_calibration(request.calibration);
  if (!calibration) return calibration.error();
  out.calibration = *calibration;
  const std::string where = request.references.front().string();
  auto view = read_reference(request.references, out.calibration, out.board, request.search);
  if (!view) return view.error();
  out.view = std::move(view).value();
  const auto order = order_of(out.view, out.points, out.board, request.order, where);
  if (!order) return order.error();
  out.order = *order;
  if (auto fitted = fit_again(out, Points(out.points), request.water, where); !fitted) return fitted.error();
  return out;
}

Outcome<void> fit_again(MeasuredPose& pose, const Points& points, StillWater& water, const std::string& where) {
  pose.points = points;
  std::vector<dsp::PoseCorner> corners;
  for (std::size_t i = 0; i < pose.view.corners.size(); ++i)
    corners.push_back({pose.point_of(i), pose.view.corners[i].pixel, pose.view.corners[i].sigma_px});
  const auto fit = fit_pose(pose.calibration, corners, where, water.above());
  if (!fit) return fit.error();
  pose.fit = *fit;
  pose.covariance = pose.fit.estimate.covariance(water.wet() ? water.level_deviation_mm : 0);
  pose.neighbour_correlation = correlation_of_neighbours(pose.fit.left_px, pose.view.seen);
  pose.warnings = pose.view.warnings;
  pose.warnings.insert(pose.warnings.end(), pose.fit.warnings.begin(), pose.fit.warnings.end());
  if (pose.fit.common_px > 0 && pose.neighbour_correlation > kNotableCorrelation)
    pose.warnings.push_back(formatted("neighbouring corners are off together (correlation %.2f): print or lens, not noise; ",
                                      pose.neighbour_correlation) +
                            "the pose's true errors are larger than stated");
  return {};
}

PoseDeviations deviations_of(const dsp::Pose<double>& pose, const dsp::PoseMatrix& covariance) {
  const auto centre = dsp::centre_by_change(pose);
  const dsp::Vec3<double> variance = (centre * covariance * centre.transpose()).diagonal();
  const dsp::PoseChange own = covariance.diagonal().cwiseSqrt();
  return {own.head<3>(), own.tail<3>(), variance.cwiseSqrt()};
}

std::vector<dsp::Vec2<double>> left_on_pattern(const MeasuredPose& pose, const dsp::WaterAbove* water) {
  std::vector<dsp::Vec2<double>> left;
  const dsp::View<double> view{pose.calibration.camera, pose.fit.pose};
  constexpr double kStep = 1e-3;  // mm
  for (std::size_t i = 0; i < pose.fit.left_px.size(); ++i) {
    // How the pixel follows the point, by differences: the image of the pattern is smooth.
    dsp::Mat2<double> by_point = dsp::Mat2<double>::Zero(), inverse;
    for (int axis = 0; axis < 2; ++axis) {
      dsp::Vec3<double> more = pose.point_of(i), less = more;
      more[axis] += kStep;
      less[axis] -= kStep;
      const auto a = dsp::see_point(view, more, water), b = dsp::see_point(view, less, water);
      if (a && b) by_point.col(axis) = (a->pixel - b->pixel) / (2 * kStep);
    }
    left.push_back(dsp::invert(by_point, inverse) ? dsp::Vec2<double>(inverse * pose.fit.left_px[i])
                                                  : dsp::Vec2<double>::Zero().eval());
  }
  return left;
}

}  // namespace srd::host
