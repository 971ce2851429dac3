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

Outcome<PoseFit> fit_pose(const Calibration& calibration, std::span<const Vec2<double>> pixels,
                          std::span<const Vec3<double>> points, const std::string& where) {
  if (pixels.size() != points.size() || points.size() < 4)
    return Problem{Exit::kInput,
                   "cannot give a pose",
                   where,
                   "at least 4 corners, each with its point",
                   std::to_string(pixels.size()) + " corners and " + std::to_string(points.size()) + " points",
                   ""};
  if (in_one_line(points))
    return Problem{Exit::kInput, "cannot give a pose", where, "points that are not all in one line", "", ""};
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> raw, normalised;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto xy = calibration.camera.undistort(pixels[i]);
    if (!xy)
      return Problem{Exit::kInput,
                     "has a corner outside the field of the calibration",
                     where,
                     "corners whose distortion can be inverted",
                     number_text(pixels[i].x()) + ", " + number_text(pixels[i].y()),
                     "check that calibration and image belong together"};
    object.emplace_back(points[i].x(), points[i].y(), points[i].z());
    raw.emplace_back(pixels[i].x(), pixels[i].y());
    normalised.emplace_back(xy->x(), xy->y());
  }
  cv::Vec3d rotation, translation;
  try {
    // The start on undistorted points: OpenCV's own inversion does not converge for strong rational distortions.
    if (!cv::solvePnP(object, normalised, cv::Matx33d::eye(), cv::noArray(), rotation, translation, false,
                      cv::SOLVEPNP_ITERATIVE))
      return Problem{Exit::kInput, "cannot give a pose", where, "corners that agree with the points", "", ""};
    const auto& camera = calibration.camera;
    const cv::Matx33d k(camera.fx(), 0, camera.cx(), 0, camera.fy(), camera.cy(), 0, 0, 1);
    cv::solvePnPRefineLM(object, raw, k, calibration.distortion, rotation, translation,
                         cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-14));
  } catch (const std::exception& exception) {
    return Problem{Exit::kInput, "cannot give a pose", where, "corners that agree with the points", exception.what(), ""};
  }

  PoseFit fit;
  fit.pose = to_pose(rotation, translation);
  fit.corners = static_cast<int>(points.size());
  const dsp::View<double> view{calibration.camera, fit.pose};
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto xy = view.normalised(points[i]);
    if (!xy)
      return Problem{Exit::kInput, "gives a pose with the pattern behind the camera",
                     where,        "points in the order in which the camera sees them",
                     "",           "check the points' file and its order"};
    const double distance = (calibration.camera.pixel(*xy) - pixels[i]).norm();
    sum += distance * distance;
    fit.worst_px = std::max(fit.worst_px, distance);
  }
  fit.rms_px = std::sqrt(sum / (2.0 * static_cast<double>(points.size())));
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
  std::vector<Vec2<double>> pixels;
  for (const BoardCorner& corner : *corners) pixels.push_back(corner.pixel);
  Outcome<PoseFit> fit = fit_pose(calibration, pixels, points, file.string());
  if (!fit) return fit;
  // An odd by odd board looks alike after half a turn; on others the colour of the first square tells.
  const bool tells = board.rows % 2 == 0 || board.columns % 2 == 0;
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
