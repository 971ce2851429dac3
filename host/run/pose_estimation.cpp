// SPDX-License-Identifier: Apache-2.0
#include "host/run/pose_estimation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "drivers/recording/image_file.hpp"
#include "drivers/support/text_file.hpp"

namespace srd::host {

namespace {

namespace fs = std::filesystem;
using dsp::Vec2;
using dsp::Vec3;

// A flat print seen by a usable calibration leaves 0.05 to 0.7 px; a wrong order of points leaves tens.
constexpr double kMaxRms = 5.0;         // px, per axis
constexpr double kSuspiciousRms = 1.0;  // px, per axis
constexpr int kCommonRounds = 4;        // the common deviation follows the pose, which hardly follows it

dsp::Pose<double> to_pose(const cv::Vec3d& rotation_vector, const cv::Vec3d& translation) {
  cv::Matx33d rotation;
  cv::Rodrigues(rotation_vector, rotation);
  dsp::Pose<double> pose;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) pose.rotation(row, column) = rotation(row, column);
    pose.translation[row] = translation[row];
  }
  return pose;
}

bool in_one_line(std::span<const Vec3<double>> points) {
  const Vec3<double> first = points.front();
  const auto farthest = std::max_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
    return (a - first).squaredNorm() < (b - first).squaredNorm();
  });
  const Vec3<double> along = *farthest - first;
  return std::all_of(points.begin(), points.end(),
                     [&](const auto& p) { return along.cross(p - first).norm() <= 1e-6 * along.squaredNorm(); });
}

// A pose to start from. Points under water are taken at their apparent height, which level water lifts them to.
Outcome<dsp::Pose<double>> first_pose(const Calibration& calibration, std::span<const dsp::PoseCorner> corners,
                                      const std::string& where, const dsp::WaterAbove* water) {
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> normalised;
  for (const dsp::PoseCorner& corner : corners) {
    const auto xy = calibration.camera.undistort(corner.pixel);
    if (!xy)
      return Problem{Exit::kInput,
                     "has a corner outside the field of the calibration",
                     where,
                     "corners whose distortion can be inverted",
                     number_text(corner.pixel.x()) + ", " + number_text(corner.pixel.y()),
                     "check that calibration and image belong together"};
    double lift = 0;
    if (water != nullptr)
      lift = (water->model.height(water->surface, corner.point.x(), corner.point.y()) - corner.point.z()) *
             (1 - water->media.air / water->media.water);
    object.emplace_back(corner.point.x(), corner.point.y(), corner.point.z() + lift);
    normalised.emplace_back(xy->x(), xy->y());
  }
  cv::Vec3d rotation, translation;
  std::string found;
  try {
    // On undistorted points: OpenCV's own inversion does not converge for strong rational distortions.
    if (cv::solvePnP(object, normalised, cv::Matx33d::eye(), cv::noArray(), rotation, translation, false,
                     cv::SOLVEPNP_ITERATIVE))
      return to_pose(rotation, translation);
  } catch (const std::exception& exception) {
    found = exception.what();
  }
  return Problem{Exit::kInput, "cannot give a pose", where, "corners that agree with the points", found, ""};
}

// What print and lens leave in every corner alike, so that residuals are as large as deviations say (Paule and Mandel 1982):
// sum |e|^2 / (sigma^2 + common^2) = residuals - 6. 0: the corners' own deviations explain them.
double common_deviation(const dsp::CameraModel<double>& camera, const dsp::Pose<double>& pose,
                        std::span<const dsp::PoseCorner> corners, const dsp::WaterAbove* water) {
  const double freedom = 2.0 * static_cast<double>(corners.size()) - 6;
  if (!(freedom > 0)) return 0;
  std::vector<double> squares;
  double most = 0;
  for (const dsp::PoseCorner& corner : corners) {
    const auto seen = dsp::see_point({camera, pose}, corner.point, water);
    squares.push_back(seen ? (seen->pixel - corner.pixel).squaredNorm() : 0);
    most += squares.back();
  }
  const auto excess = [&](double variance) {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) sum += squares[i] / (corners[i].sigma * corners[i].sigma + variance);
    return sum - freedom;
  };
  // Within three deviations of chi-square nothing is missing.
  if (excess(0) <= 3 * std::sqrt(2 * freedom)) return 0;
  double low = 0, high = most / freedom;  // there the sum is at most the freedom
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (excess(middle) > 0 ? low : high) = middle;
  }
  return std::sqrt(high);
}

}  // namespace

Points board_points(PatternSize board, double square_mm) {
  Points points;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) points.emplace_back(row * square_mm, column * square_mm, 0.0);
  return points;
}

Points seen_order(const Points& points, int position) {
  Points seen = points;
  if (position == 2 || position == 3) std::reverse(seen.begin(), seen.end());
  return seen;
}

std::vector<dsp::PoseCorner> with_points(std::span<const BoardCorner> corners, std::span<const Vec3<double>> points) {
  std::vector<dsp::PoseCorner> known;
  for (std::size_t i = 0; i < std::min(corners.size(), points.size()); ++i)
    known.push_back({points[i], corners[i].pixel, corners[i].sigma_px});
  return known;
}

Outcome<PoseFit> fit_pose(const Calibration& calibration, std::span<const Vec2<double>> pixels,
                          std::span<const Vec3<double>> points, const std::string& where) {
  if (pixels.size() != points.size())
    return Problem{Exit::kInput,
                   "cannot give a pose",
                   where,
                   "at least 4 corners, each with its point",
                   std::to_string(pixels.size()) + " corners and " + std::to_string(points.size()) + " points",
                   ""};
  std::vector<dsp::PoseCorner> corners;
  for (std::size_t i = 0; i < pixels.size(); ++i) corners.push_back({points[i], pixels[i], 1});
  return fit_pose(calibration, corners, where);
}

Outcome<PoseFit> fit_pose(const Calibration& calibration, std::span<const dsp::PoseCorner> corners, const std::string& where,
                          const dsp::WaterAbove* water) {
  const std::string count = std::to_string(corners.size());
  if (corners.size() < 4)
    return Problem{Exit::kInput,
                   "cannot give a pose",
                   where,
                   "at least 4 corners, each with its point",
                   count + " corners and " + count + " points",
                   ""};
  Points points;
  for (const dsp::PoseCorner& corner : corners) points.push_back(corner.point);
  if (in_one_line(points))
    return Problem{Exit::kInput, "cannot give a pose", where, "points that are not all in one line", "", ""};
  const Outcome<dsp::Pose<double>> start = first_pose(calibration, corners, where, water);
  if (!start) return start.error();
  std::vector<dsp::PoseCorner> weighed(corners.begin(), corners.end());
  auto estimate = dsp::fit_pose_to(calibration.camera, *start, weighed, water);
  double common = 0;
  for (int round = 0; estimate && round < kCommonRounds; ++round) {
    common = common_deviation(calibration.camera, estimate->pose, corners, water);
    for (std::size_t i = 0; i < corners.size(); ++i) weighed[i].sigma = std::hypot(corners[i].sigma, common);
    if (common > 0) estimate = dsp::fit_pose_to(calibration.camera, estimate->pose, weighed, water);
    if (common == 0) break;
  }
  if (!estimate)
    return Problem{
        Exit::kInput, "cannot give a pose", where, "corners that agree with the points", to_string(estimate.error()), ""};

  PoseFit fit;
  fit.pose = estimate->pose;
  fit.estimate = *estimate;
  fit.common_px = common;
  fit.corners = static_cast<int>(corners.size());
  const dsp::View<double> view{calibration.camera, fit.pose};
  double sum = 0;
  for (const dsp::PoseCorner& corner : corners) {
    const auto seen = dsp::see_point(view, corner.point, water);
    if (!seen)
      return Problem{Exit::kInput, "gives a pose with the pattern behind the camera",
                     where,        "points in the order in which the camera sees them",
                     "",           "check the points' file and its order"};
    fit.left_px.push_back(corner.pixel - seen->pixel);
    sum += fit.left_px.back().squaredNorm();
    fit.worst_px = std::max(fit.worst_px, fit.left_px.back().norm());
  }
  fit.rms_px = std::sqrt(sum / (2.0 * static_cast<double>(corners.size())));
  if (!(fit.rms_px <= kMaxRms))
    return Problem{Exit::kInput,
                   "does not agree with the points",
                   where,
                   "residuals of at most " + number_text(kMaxRms) + " px rms",
                   number_text(std::round(fit.rms_px * 100) / 100) + " px rms",
                   "check the calibration, the points' file and its order (row by row, the image's top left first)"};
  if (!(fit.pose.centre().z() > points.front().z()))
    return Problem{Exit::kInput,
                   "gives a camera below the pattern",
                   where,
                   "points in the order in which the camera sees them",
                   "centre at Z = " + number_text(std::round(fit.pose.centre().z() * 10) / 10) + " mm",
                   "the points' order is mirrored against the image: check rows and columns"};
  if (fit.rms_px > kSuspiciousRms)
    fit.warnings.push_back(where + ": the pose leaves " + number_text(std::round(fit.rms_px * 1000) / 1000) +
                           " px rms; a good calibration and a flat print leave less than 1");
  return fit;
}

Outcome<void> check_size(const GrayView& image, const Calibration& calibration, const fs::path& file) {
  if (calibration.image_width == 0 || calibration.image_height == 0) return {};
  if (image.width == calibration.image_width && image.height == calibration.image_height) return {};
  return Problem{Exit::kInput,
                 "has not the size of the calibration",
                 file.string(),
                 std::to_string(calibration.image_width) + " x " + std::to_string(calibration.image_height) + " px",
                 std::to_string(image.width) + " x " + std::to_string(image.height) + " px",
                 "give the calibration that was made with these camera settings"};
}

Outcome<PoseFit> pose_from_image(const fs::path& file, const Calibration& calibration, const Points& points, PatternSize board,
                                 const CornerSearch& search, int sample_bits) {
  const Outcome<GrayImage> image = read_gray_image(file, sample_bits);
  if (!image) return image.error();
  if (auto right = check_size(image->view(), calibration, file); !right) return right.error();
  const auto corners = find_board_corners(image->view(), board, search, file.string());
  if (!corners) return corners.error();
  Outcome<PoseFit> fit = fit_pose(calibration, with_points(*corners, points), file.string());
  if (!fit) return fit;
  // After half a turn a board of odd by odd or even by even corners looks alike; else the colour of the first square tells.
  const bool tells = (board.rows + board.columns) % 2 == 1;
  const double square = (points[1] - points[0]).norm();
  if (tells && first_square_bright(corners->front(), points.front(), square, {calibration.camera, fit->pose}))
    fit->warnings.push_back(file.string() +
                            ": the square at the world's origin is bright; if the pattern's is dark, "
                            "the camera sees it turned by half a turn: check PositionN or the points' order");
  return fit;
}

bool first_square_bright(const BoardCorner& corner, const Vec3<double>& point, double square, const dsp::View<double>& view) {
  const auto here = view.normalised(point);
  const auto inside = view.normalised(point + 0.25 * square * Vec3<double>(1, 1, 0));
  if (!here || !inside) return false;
  const Vec2<double> towards = *inside - *here;
  const bool below_right_or_opposite = towards.x() * towards.y() > 0;
  const bool bright = corner.bright_below_right == below_right_or_opposite;
  const auto squares = [&](double mm) { return std::lround(mm / square); };
  return bright != (((squares(point.x()) + squares(point.y())) & 1) != 0);
}

}  // namespace srd::host
